"""What a person does to correct labels, with what can go wrong meanwhile: steps of review_page_test.py."""

import json
import os

from browser import ALT, CTRL, SHIFT, Tab
from page_checks import unreachable
from review_world import NOT_THERE, OTHER, RUN, check, cursor_us, handle, open_run, saved_in_page, view, with_news, without_news


def drags_and_undoes(world):
    tab = Tab(world.browser)
    open_run(world, tab, at=0)
    before = world.interval("press-1")
    tab.key("n")
    tab.wait(f"document.querySelector(\"{handle('press-1', 'start')}\").classList.contains('selected')", "N selects the first onset")
    check(view(tab)[1] - view(tab)[0] == 60_000 and abs(cursor_us(tab) - before["start_us"]) < 2, "and shows it closely")
    tab.wait(
        "performance.getEntriesByType('resource').some(r => r.name.includes('event_times') && r.responseEnd > 0)", "single events are known"
    )
    left, top, width, height = tab.box(handle("press-1", "start"))
    surface = tab.box(".surface")
    pixels = round(0.008 * surface[2] / 0.06)  # 8 ms
    tab.drag(left + width / 2, top + 60, left + width / 2 + pixels)
    world.until(lambda: world.interval("press-1")["start_us"] != before["start_us"], "a drag changes labels.json")
    saved_in_page(tab)
    after = world.interval("press-1")
    check(
        abs(after["start_us"] - before["start_us"] - 8000) < 1000, f"from {before['start_us']} to {after['start_us']}; expected 8 ms later"
    )
    check(after["source"] == "person" and after["confirmed"] and after["start_high_us"] - after["start_us"] >= 1000, f"{after}")
    entry = world.saved()["history"]["entries"][-1]
    check(entry["who"] == "ada" and "start of press-1" in entry["what"], f"{entry}")
    events = tab.js(
        f"fetch('/api/runs/{RUN}/event_times?from_us={after['start_us'] - 500}&to_us={after['start_us'] + 500}').then(r => r.json())"
    )["t_us"]
    check(after["start_us"] in events, "it snapped to an event")
    check("start of press-1" in tab.text(".history li"), "the page lists the edit")
    tab.key("u")
    world.until(lambda: world.interval("press-1")["start_us"] == before["start_us"], "U undoes")
    saved_in_page(tab)
    check(world.interval("press-1") == before, "undone, the interval is as it was")
    tab.key("r")
    world.until(lambda: world.interval("press-1")["start_us"] == after["start_us"], "R makes it again")
    tab.key("z", CTRL)
    world.until(lambda: world.interval("press-1")["start_us"] == before["start_us"], "Ctrl Z undoes")
    saved_in_page(tab)
    tab.drag(left + width / 2, top + 60, left + width / 2 + 37, ALT)
    world.until(lambda: world.interval("press-1")["start_us"] != before["start_us"], "Alt drags without snapping")
    tab.key("u")
    saved_in_page(tab)
    world.until(lambda: world.interval("press-1")["start_us"] == before["start_us"], "and is undone")
    world.quiet("dragging")
    tab.close()


def edits_by_key(world):
    tab = Tab(world.browser)
    open_run(world, tab, at=0.02)
    free = world.interval("press-1")["start_us"]
    tab.key("0")
    for _ in range(3):  # a tenth of the speed: a busy machine must not play past the first touch
        tab.key("<")
    tab.key(" ")
    tab.key("s")
    tab.wait("document.querySelector('.band.mark.slip')", "S begins a slip while it plays")
    began = cursor_us(tab)
    tab.wait(f"parseFloat(document.querySelector('.time-now').textContent) > {began / 1e6 + 0.1}", "it plays on")
    tab.key("s")
    tab.key(" ")
    world.until(lambda: len(world.saved()["intervals"]) == 3, "S ends it, and it is saved")
    saved_in_page(tab)
    first = world.saved()["provenance"]["first_event_us"]
    added = world.saved()["intervals"][0]
    check(added["class"] == "slip" and added["end_us"] - first < free and added["end_us"] - added["start_us"] > 90_000, f"{added}")
    check(added["start_us"] - added["start_low_us"] >= 20_000, f"a mark while playing is as uncertain as a reaction of 0.2 s: {added}")
    name = added["id"]
    tab.key("t")
    world.until(lambda: world.interval(name)["class"] == "press", "T changes the class")
    tab.wait("document.querySelector('.interval.press.selected')", "the page shows it")
    tab.js("document.querySelector('#why').focus()")
    tab.type("not a touch <img src=x onerror=alert(1)>")
    tab.js("document.activeElement.blur()")
    tab.key("x")
    world.until(lambda: world.interval(name) is None, "X removes it")
    saved_in_page(tab)
    check(tab.text(".history li .why") == "not a touch <img src=x onerror=alert(1)>", "the reason is shown as text")
    for _ in range(3):
        tab.key("u")
    world.until(lambda: len(world.saved()["intervals"]) == 2, "three times U undoes all")
    saved_in_page(tab)
    tab.js(
        "(() => { const f = document.querySelector(\"[data-key='end slip-1']\"); f.value = '%.6f'; f.dispatchEvent(new Event('change')); })()"
        % ((world.interval("slip-1")["end_us"] - 3000) / 1e6)
    )
    world.until(lambda: world.interval("slip-1")["source"] == "person", "a typed time is saved")
    tab.key("u")
    world.until(lambda: world.interval("slip-1")["source"] != "person", "and undone")
    saved_in_page(tab)
    before = world.interval("press-1")
    tab.js("document.activeElement.blur()")
    tab.key("n")
    tab.wait("document.querySelector('.interval.selected')", "an interval is selected")
    for key, end, at_us in (("i", "start", before["start_us"] + 4000), ("o", "end", before["end_us"] - 6000)):
        tab.go(world.server.url + f"#/run/{RUN}?t={at_us / 1e6}")
        tab.wait(f"Math.abs(parseFloat(document.querySelector('.time-now')?.textContent) * 1e6 - {at_us}) < 2", "the cursor is there")
        tab.key(" ")
        tab.key(key)
        tab.key(" ")
        world.until(lambda: world.interval("press-1")[f"{end}_us"] != before[f"{end}_us"], f"{key.upper()} sets the {end} while it plays")
        saved_in_page(tab)
        check(abs(world.interval("press-1")[f"{end}_us"] - at_us) < 100_000, f"at the cursor: {world.interval('press-1')}")
    tab.key("c")
    world.until(lambda: world.interval("press-1")["confirmed"], "C confirms the interval")
    for _ in range(3):
        tab.key("u")
        saved_in_page(tab)
    world.until(lambda: world.interval("press-1") == before, "three times U undoes that")
    saved_in_page(tab)
    world.quiet("editing by key")
    tab.close()


def lifts_and_goes_on(world):
    tab = Tab(world.browser)
    open_run(world, tab)
    tab.key("f")
    tab.wait(
        f"document.querySelector('h1').textContent === '{OTHER}' && document.querySelector('.flags .open')", "F goes to the flagged run"
    )
    flags = len([flag for flag in world.saved(OTHER)["flags"] if not flag["confirmed"]])
    tab.key("l")
    tab.wait("document.querySelector('dialog #reason') === document.activeElement", "L asks for a reason")
    tab.key("Enter")
    check(tab.js("document.querySelector('dialog') !== null"), "Enter sends no flag without a reason")
    tab.type("the film shows")
    tab.reload()
    tab.wait("document.querySelector('dialog #reason')?.value === 'the film shows'", "a reload keeps the words")
    tab.js("document.querySelector('dialog #reason').focus()")
    tab.js("document.querySelector('dialog #reason').setSelectionRange(99, 99)")
    tab.type(" it")
    tab.key("Enter")
    world.until(lambda: len([flag for flag in world.saved(OTHER)["flags"] if not flag["confirmed"]]) == flags - 1, "the flag is lifted")
    check(world.saved(OTHER)["history"]["entries"][-1]["why"] == "the film shows it", "with its reason")
    saved_in_page(tab)
    tab.key("C", SHIFT)
    world.until(lambda: all(i["confirmed"] for i in world.saved(OTHER)["intervals"]), "Shift C confirms the run")
    tab.wait("document.querySelector('.run-head .state').textContent === '✓ confirmed'", "the page shows it")
    tab.go(world.server.url + "#/")
    tab.wait("document.querySelector('.progress')?.textContent.includes('2 of 2 runs confirmed')", "the list counts it")
    world.quiet("lifting a flag")
    tab.close()


def provokes_a_conflict(world):
    tab = Tab(world.browser)
    open_run(world, tab, at=0)
    world.allowed = ["status of 409", "ERR_BLOCKED_BY_CLIENT"]
    for mine in (True, False):
        without_news(world, tab)
        before = world.interval("press-1")
        theirs = before["start_us"] + 3000
        world.made(
            "label",
            os.path.join(world.data, RUN),
            "--set",
            f"{os.path.join(world.data, RUN)}:press-1.start={theirs / 1e6:.6f}",
            "--who",
            "bo",
            "--no-pictures",
        )
        tab.js("document.activeElement.blur()")
        tab.key("n")
        if not mine:
            tab.key("N", SHIFT)
        tab.js(f"document.querySelector(\"{handle('press-1', 'start')}\").focus()")
        tab.key("ArrowRight")
        tab.key("Enter")
        tab.wait("document.querySelector('dialog .conflict')", "the page asks")
        words = tab.text("dialog .conflict")
        check("bo" in words and "start of press-1 moved" in words and "changed by both" in words, words)
        check(world.interval("press-1")["start_us"] == theirs, "nothing is overwritten before the answer")
        tab.picture(os.path.join(world.home, "conflict.png"))
        tab.click(f"dialog button[data-value={'mine' if mine else 'theirs'}]")
        tab.wait("!document.querySelector('dialog')", "the dialog closes")
        with_news(world, tab)
        if mine:
            world.until(lambda: world.interval("press-1")["start_us"] not in (theirs, before["start_us"]), "mine is on top")
            check([e["who"] for e in world.saved()["history"]["entries"]][-2:] == ["bo", "ada"], "both edits are in the history")
            saved_in_page(tab)
        else:
            check(world.interval("press-1")["start_us"] == theirs, "theirs stays")
            tab.click("[data-key='make 0']")
            world.until(lambda: world.interval("press-1")["start_us"] != theirs, "mine is made after all")
            saved_in_page(tab)
    world.quiet("a conflict")
    world.allowed = []
    tab.close()


def reloads_during_an_edit(world):
    tab = Tab(world.browser)
    open_run(world, tab, at=0)
    before = world.interval("slip-1")["end_us"]
    top = tab.box(".surface")[1]
    tab.js(f"document.querySelector(\"{handle('slip-1', 'end')}\").focus()")
    for _ in range(3):
        tab.key("ArrowLeft")
    words = tab.wait("document.querySelector('.draft:not([hidden]) span')?.textContent", "the moved end is shown")
    check(tab.box(".surface")[1] == top, "the axis does not jump when a moved end is shown")
    shown = view(tab)
    tab.reload()
    tab.wait(
        f"document.querySelector('.draft:not([hidden]) span')?.textContent === {json.dumps(words)}", "a reload keeps what is not saved"
    )
    check(world.interval("slip-1")["end_us"] == before, "it is not saved yet")
    check(view(tab) == shown, "the axis is where it was")
    tab.key("Enter")
    world.until(lambda: before - 6001 < world.interval("slip-1")["end_us"] < before - 3999, "Enter saves it")
    saved_in_page(tab)
    tab.key("u")
    world.until(lambda: world.interval("slip-1")["end_us"] == before, "U undoes it")
    saved_in_page(tab)
    world.quiet("reloading")
    tab.close()


def outlives_the_server(world):
    tab = Tab(world.browser)
    open_run(world, tab, at=0)
    before = world.interval("slip-1")["end_us"]
    world.allowed = NOT_THERE
    for reload in (False, True):
        world.server.kill()
        tab.js(f"document.querySelector(\"{handle('slip-1', 'end')}\").focus()")
        tab.key("ArrowLeft")
        tab.key("Enter")
        tab.wait(
            "!document.getElementById('lost').hidden && document.querySelector('.saved').textContent.includes('1 edit')",
            "the page says that the server is lost",
        )
        tab.picture(os.path.join(world.home, f"lost-{reload}.png"))
        if reload:
            tab.go("about:blank")
        world.server = world.new_server(world.server.port)
        if reload:
            open_run(world, tab)
        world.until(lambda: world.interval("slip-1")["end_us"] < before, "the edit is saved when a server answers")
        saved_in_page(tab)
        tab.wait("document.getElementById('lost').hidden", "the message goes")
        tab.wait("[...document.querySelectorAll('.strip .value')].every(e => /\\d/.test(e.textContent))", "signals are loaded again")
        before = world.interval("slip-1")["end_us"]
    world.quiet("a server that ends")
    world.allowed = []
    tab.close()


def reaches_all_by_keyboard(world):
    tab = Tab(world.browser)
    tab.go(world.server.url)
    tab.wait("document.querySelectorAll('tbody tr').length === 2", "the list is there")
    problems = unreachable(tab)
    check(not problems, f"list: {problems}")
    tab.js("document.activeElement.blur()")
    tab.key("f")
    tab.wait(f"document.querySelector('h1')?.textContent === '{OTHER}' && document.querySelector('.handle')", "F opens the flagged run")
    tab.key("g")
    tab.wait("document.querySelectorAll('tbody tr').length === 2", "G shows the list")
    for key in ("j", "j", "Enter"):
        tab.key(key)
    tab.wait(
        f"document.querySelector('h1')?.textContent === '{RUN}' && document.querySelector('.handle')",
        "J goes down the list, and Enter opens a run",
    )
    problems = unreachable(tab)
    check(not problems, f"run: {problems}")
    tab.js("document.activeElement.blur()")
    before = world.interval("press-1")
    for _ in range(100):
        tab.key("Tab")
        if tab.js("document.activeElement.dataset.key") == "handle press-1 start":
            break
    tab.key("ArrowLeft")
    tab.key("ArrowLeft")
    tab.key("Enter")
    world.until(
        lambda: before["start_us"] - 4001 < world.interval("press-1")["start_us"] < before["start_us"] - 1999,
        "an onset is moved by keys alone",
    )
    saved_in_page(tab)
    check("not saved" not in tab.js("document.activeElement.ariaValueText"), "the slider shows its value")
    tab.js("document.activeElement.blur()")
    tab.key("?")
    tab.wait("document.querySelector('dialog .keys')", "? shows the keys")
    tab.key("Escape")
    tab.wait("!document.querySelector('dialog')", "Escape closes them")
    tab.key("u")
    world.until(lambda: world.interval("press-1")["start_us"] == before["start_us"], "and undone")
    saved_in_page(tab)
    world.quiet("by keyboard")
    tab.close()


def is_used_by_finger(world):
    tab = Tab(world.browser, 390)
    world.browser.ask("Emulation.setTouchEmulationEnabled", tab.session, enabled=True, maxTouchPoints=2)
    open_run(world, tab, at=0)
    touch = lambda kind, *points: world.browser.ask(
        "Input.dispatchTouchEvent", tab.session, type=kind, touchPoints=[{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(points)]
    )  # noqa: E731,E501
    left, top, width, _ = tab.box(".surface")
    before = view(tab)
    place = lambda share: (left + share * width, top + 80)  # noqa: E731
    touch("touchStart", place(0.15), place(0.30))
    for step in range(1, 6):
        touch("touchMove", place(0.15 - 0.02 * step), place(0.30 + 0.006 * step))
    touch("touchEnd")
    check(0.4 < (view(tab)[1] - view(tab)[0]) / (before[1] - before[0]) < 0.7, f"two fingers zoom: {before} became {view(tab)}")
    tab.click("[aria-label='The next start or end']")
    tab.wait(f"document.querySelector(\"{handle('press-1', 'start')}\").classList.contains('selected')", "a button goes to the first onset")
    was = world.interval("press-1")
    x, _, thick, _ = tab.box(handle("press-1", "start"))
    _, top, _, _ = tab.box(".surface")
    touch("touchStart", (x + thick / 2, top + 60))
    for step in range(1, 7):
        touch("touchMove", (x + thick / 2 + 10 * step, top + 60))
    touch("touchEnd")
    world.until(lambda: world.interval("press-1")["start_us"] > was["start_us"], "a finger drags an onset")
    saved_in_page(tab)
    tab.click("[title='U or Ctrl Z']")
    world.until(lambda: world.interval("press-1") == was, "and a button undoes it")
    saved_in_page(tab)
    world.quiet("by finger")
    tab.close()
