"""What a person does to look at runs, models and studies: steps of review_page_test.py."""

import os
import time

from browser import SHIFT, Tab
from page_checks import problems_of, unreachable
from review_world import MARKUP, OTHER, RUN, Server, check, cursor_us, open_run, view


def browses(world):
    tab = Tab(world.browser)
    tab.go(world.server.url)
    tab.wait("document.querySelectorAll('tbody tr').length === 2", "both runs are listed")
    tab.wait("[...document.querySelectorAll('td[data-label=Length]')].every(e => /s$/.test(e.textContent))", "their lengths are known")
    tab.wait("[...document.querySelectorAll('.thumb img')].every(i => i.naturalWidth > 0)", "their pictures are there")
    check(tab.text("tbody tr th a") == OTHER, f"first is {tab.text('tbody tr th a')}; expected the flagged run {OTHER}")
    tab.click("th[data-column=name] button")
    check(tab.text("tbody tr th a") == RUN, "sorted by name, fan comes first")
    tab.click("th[data-column=name] button")
    check(
        tab.text("tbody tr th a") == OTHER and tab.js("document.querySelector('th[data-column=name]').ariaSort") == "descending",
        "a second press turns the order",
    )
    tab.click("th[data-column=state] button")
    tab.key("/")
    tab.type("fan")
    tab.wait("document.querySelectorAll('tbody tr').length === 1", "the search keeps one")
    check(tab.text(".count") == "1 of 2 runs", tab.text(".count"))
    tab.js("(() => { const s = document.getElementById('search'); s.value = ''; s.dispatchEvent(new Event('input')); })()")
    check("0 of 2 runs confirmed, 1 flagged" in tab.text(".progress"), tab.text(".progress"))
    check(MARKUP in tab.text(".flag-words") and MARKUP in tab.text(".left-out"), "a flag and a folder with markup are shown as text")
    check(tab.js("document.querySelectorAll('main img[src=x]').length") == 0, "and are no elements")
    check("±" in tab.js(f"[...document.querySelectorAll('td[data-label=Clocks]')].map(e => e.textContent).join()"), "clocks are shown")
    world.quiet("browsing")
    tab.click("tbody tr:nth-child(2) a")
    tab.wait("document.querySelector('.handle')", "a click opens the run")
    tab.wait("document.querySelector('.picture.film img')?.naturalWidth > 0", "the film's frame is there")
    for kind in ("events", "heatmap"):
        tab.wait(
            f"(() => {{ const c = document.querySelector('.picture.{kind} canvas'); return c.width > 100 &&"
            " new Set(c.getContext('2d').getImageData(0, 0, c.width, c.height).data).size > 3; })()",
            f"the {kind} are drawn",
        )
    names = tab.js("[...document.querySelectorAll('.strip-name span:first-child')].map(e => e.textContent)")
    check(len(names) >= 5, f"signals: {names}")
    tab.wait("[...document.querySelectorAll('.strip .value')].every(e => e.textContent !== '–')", "each signal has a value at the cursor")
    world.quiet("opening a run")
    tab.close()


def shows_two_hundred_runs(world):
    """As many runs as ten objects with twenty runs each."""
    many = os.path.join(world.home, "many")
    for number in range(200):
        folder = os.path.join(many, f"object-{number // 20:02}", f"{number % 20 + 1:02}")
        os.makedirs(folder)
        for name in os.listdir(os.path.join(world.data, RUN)):
            os.link(os.path.join(world.data, RUN, name), os.path.join(folder, name))
    server = Server(world.tactile, many, "--port", "0")
    tab = Tab(world.browser)
    try:
        tab.go(server.url)
        tab.wait("document.querySelectorAll('tbody tr').length === 200", "all runs are listed")
        tab.wait("[...document.querySelectorAll('td[data-label=Length]')].every(e => /s$/.test(e.textContent))", "their lengths are known")
        tab.key("/")
        tab.type("object-07/1")
        tab.wait("document.querySelectorAll('tbody tr').length === 10", "the search keeps ten")
        tab.wait("[...document.querySelectorAll('.thumb img')].filter(i => i.naturalWidth > 0).length === 10", "with their pictures")
        tab.js("(() => { const s = document.getElementById('search'); s.value = ''; s.dispatchEvent(new Event('input')); })()")
        tab.click("th[data-column=name] button")
        check(tab.text("tbody tr th a") == "object-00/01", "they are sorted by name")
        tab.js("document.activeElement.blur()")
        tab.key("f")
        tab.wait("document.querySelector('h1')?.textContent.startsWith('object-') && document.querySelector('.handle')", "F opens one")
        world.quiet("two hundred runs")
    finally:
        tab.close()
        server.end()


def zooms_and_plays(world):
    tab = Tab(world.browser)
    open_run(world, tab, at=1.0)
    left, top, width, height = tab.box(".surface")
    whole = view(tab)
    for _ in range(30):
        tab.wheel(left + width * 0.4, top + 60, -300)
    check(view(tab)[1] - view(tab)[0] == 1000, f"the wheel zooms to a millisecond; it shows {view(tab)}")
    under = whole[0] + 0.4 * (whole[1] - whole[0])
    check(abs(sum(view(tab)) / 2 - under) < 0.02 * (whole[1] - whole[0]), "the time under the pointer stays")
    before = view(tab)
    tab.drag(left + width * 0.8, top + 60, left + width * 0.3)
    check(abs(view(tab)[0] - before[0] - 500) <= 2, f"a drag moves the axis: {before} became {view(tab)}")
    tab.click_at(left + width / 2, top + 60)
    tab.wait("Number(document.querySelector('.strip .value').textContent) >= 0", "the rate is known here")
    tab.key("0")
    check(view(tab) == whole, "0 shows the whole run")
    tab.drag(left + width * 0.25, top + 60, left + width * 0.5, SHIFT)
    check(abs((view(tab)[1] - view(tab)[0]) / (whole[1] - whole[0]) - 0.25) < 0.01, "Shift and drag zooms to a stretch")
    tab.key("0")
    tab.click_at(left + width * 0.6, top + 80)
    check(abs(cursor_us(tab) - (whole[0] + 0.6 * (whole[1] - whole[0]))) < 3 * (whole[1] - whole[0]) / width, "a click puts the cursor")
    tab.key("ArrowRight")
    first = cursor_us(tab)
    origin = world.saved()["provenance"]["first_event_us"]
    check((first + origin) % 2000 == 0, f"{first} µs is no tick")
    tab.key("ArrowRight")
    check(cursor_us(tab) == first + 2000, "→ goes one tick on")
    tab.key("ArrowLeft")
    check(cursor_us(tab) == first, "← goes one tick back")
    frames = tab.js("fetch('/api/runs/%s/frames').then(r => r.json())" % RUN)["t_us"]
    tab.key(".")
    check(cursor_us(tab) in frames and cursor_us(tab) > first, "a full stop goes to the next frame")
    tab.key(",")
    tab.key(",")
    check(cursor_us(tab) in frames and cursor_us(tab) < first, "a comma goes to the frame before")
    for _ in range(3):
        tab.key("<")  # slower, so that the run does not end meanwhile
    start = cursor_us(tab)
    tab.key(" ")
    tab.wait(f"parseFloat(document.querySelector('.time-now').textContent) > {start / 1e6 + 0.05}", "Space plays")
    tab.key(" ")
    stopped = cursor_us(tab)
    time.sleep(0.2)
    check(cursor_us(tab) == stopped, "Space pauses")
    for _ in range(9):
        tab.key("<")
    check(tab.js("document.querySelector('.tools select').value") == "0.05", "the slowest speed is 0.05")
    begun = time.monotonic()
    tab.key(" ")
    tab.wait(f"parseFloat(document.querySelector('.time-now').textContent) > {stopped / 1e6}", "Space plays slowly")
    tab.key(" ")
    moved, passed = (cursor_us(tab) - stopped) / 1e6, time.monotonic() - begun
    check(0 < moved <= 0.05 * passed + 0.01, f"at 0.05 the cursor moved {moved} s in {passed} s")
    for _ in range(9):
        tab.key(">")
    check(tab.js("document.querySelector('.tools select').value") == "4", "the quickest speed is 4")
    tab.key(" ")
    tab.wait("document.querySelector('.play').textContent.includes('Play')", "playing stops at the end")
    check(abs(cursor_us(tab) - whole[1]) < 2, "the cursor is at the end")
    world.quiet("zooming and playing")
    tab.close()


def compares_models_and_studies(world):
    tab = Tab(world.browser)
    tab.go(world.server.url + "#/models")
    tab.wait("document.querySelectorAll('table.figures tbody tr').length === 2", "both models are listed")
    words = tab.js("[...document.querySelectorAll('table.figures tbody tr')].map(r => r.textContent)")
    check("%" in words[0] and "second" in words[1], f"{words}")
    tab.click("details[data-model=first] summary")
    tab.wait("document.querySelectorAll('details[data-model=first] .curve canvas').length >= 2", "the training curves are drawn")
    check("2 epochs" in tab.js("document.querySelector('details[data-model=first] figure').ariaLabel"), "with their epochs")
    tab.click(".chooser button")
    tab.wait(
        "[...document.querySelectorAll('.compare h3')].map(e => e.textContent).join() === 'first,second'", "both are compared on a run"
    )
    tab.wait(
        "!document.querySelector('.strip.pending') && document.querySelectorAll('.compare .band').length === 2",
        "their probabilities are computed",
    )
    answer = lambda: tab.js(
        f"fetch('/api/runs/{RUN}/signals?from_us=0&to_us=2000000&points=50&names=p_none,p_press,p_slip&model=first').then(r => r.json())"
    )  # noqa: E731
    world.until(lambda: not answer().get("pending"), "they are computed")
    series = answer()["series"]
    sums = [sum(values) for values in zip(*(series[name]["mean"] for name in ("p_none", "p_press", "p_slip"))) if None not in values]
    check(sums and all(abs(total - 1) < 0.02 for total in sums), f"probabilities add to {sums[:5]}")
    tab.go(world.server.url + "#/studies?first=plain&second=hostile")
    tab.wait("document.querySelectorAll('table.figures')[0]?.tBodies[0].rows.length > 3", "two studies are side by side")
    check(tab.js("document.querySelectorAll('main b, main script').length") == 0, "no name becomes markup")
    check(
        tab.js(
            "[...document.querySelectorAll('table.figures')].every(t => [...t.rows].every(r => r.cells.length === t.rows[0].cells.length))"
        ),
        "no row is ragged",
    )
    open_run(world, tab)
    tab.js("(() => { const s = document.getElementById('model'); s.value = 'second'; s.dispatchEvent(new Event('change')); })()")
    tab.wait(
        "document.querySelectorAll('.strip').length === 7 && !document.querySelector('.strip.pending')",
        "a run shows a model's probabilities",
    )
    tab.wait("document.querySelector('.strip.last .value').textContent.split('·').length === 3", "none, press and slip")
    world.quiet("models and studies")
    tab.close()


def shows_what_has_no_labels(world):
    file = os.path.join(world.data, OTHER, "labels.json")
    os.rename(file, file + ".away")
    world.allowed = ["status of 404"]
    tab = Tab(world.browser)
    tab.go(world.server.url + f"#/run/{OTHER}")
    tab.wait("document.querySelector('.no-labels')", "the page says that there are no labels")
    check(not tab.js("/nothing can be edited|Press P/.test(document.querySelector('main').textContent)"), "and says nothing else of editing")
    tab.wait("/\\d/.test(document.querySelector('.strip .value')?.textContent)", "the signals are there")
    tab.key("p")
    check("Label this run first" in tab.text("#message"), "a press cannot begin here")
    tab.picture(os.path.join(world.home, "no-labels.png"))
    tab.click(".no-labels button")
    tab.wait("document.querySelector('.handle') && !document.querySelector('.no-labels')", "the button labels the run")
    check(len(world.saved(OTHER)["intervals"]) > 0, "as tactile label does")
    tab.go(world.server.url + "#/")
    tab.wait("/^Confirm . run/.test(document.querySelector('.filters')?.textContent.match(/Confirm.*?…/)?.[0])", "the list offers to confirm")
    tab.js("[...document.querySelectorAll('.filters button')].find(b => b.textContent.startsWith('Confirm')).click()")
    tab.wait("document.querySelector('dialog #confirm-why') === document.activeElement", "it asks what to confirm")
    tab.picture(os.path.join(world.home, "confirm-many.png"))
    tab.key("Enter")
    world.until(lambda: all(part["confirmed"] for kind in ("intervals", "flags") for part in world.saved(OTHER)[kind]), "all is confirmed at once")
    tab.wait("document.querySelector('.progress')?.textContent.includes('2 of 2 runs confirmed')", "the list counts it")
    tab.go(world.server.url + "#/run/nothing/01")
    tab.wait("document.querySelector('p.error')?.textContent.includes('no such run')", "a run that is not there is reported")
    tab.go(world.server.url + f"#/models/first/vs/second?run={OTHER.replace('/', '%2F')}")
    tab.wait("document.querySelectorAll('.compare h3').length === 2 && !document.querySelector('.strip.pending')", "models are compared on it")
    tab.go(world.server.url + "#/run/nothing/01")
    tab.wait("document.querySelector('p.error')?.textContent.includes('no such run')", "the page of no run again")
    os.replace(file + ".away", file)
    tab.click("main a[href='#/']")
    tab.wait("document.querySelectorAll('tbody tr').length === 2", "a link goes to the list")
    world.quiet("runs without labels")
    world.allowed = []
    tab.close()


PAGES = [
    ("runs", "#/", "document.querySelectorAll('.thumb img').length === 2"),
    ("run", f"#/run/{RUN}", "document.querySelector('.handle') && document.querySelector('.picture.film img')?.naturalWidth"),
    (
        "models",
        "#/models",
        "(() => { const d = document.querySelector('details[data-model]'); if (d) d.open = true; return document.querySelector('.curve canvas'); })()",
    ),
    ("compare", "#/models/first/vs/second", "document.querySelector('.compare .band') && !document.querySelector('.strip.pending')"),
    ("studies", "#/studies", "document.querySelector('table.figures')"),
    ("split", f"#/split/{RUN}", "document.querySelector('.cut-area canvas') && document.querySelector('.split-runs tbody tr')"),
]


def cut_us(tab):
    return [round(1e6 * float(at)) for at in tab.js("[...document.querySelectorAll('.cut')].map(e => e.ariaValueNow ?? e.getAttribute('aria-valuenow'))")]


ADD_CUT = "[...document.querySelectorAll('button')].find(b => b.textContent === 'Add').click()"


def cuts_a_recording(world):
    tab = Tab(world.browser)
    open_run(world, tab)
    tab.click(".run-head a")
    tab.wait("document.querySelector('.cut-area canvas') && document.querySelectorAll('.split-runs tbody tr').length === 1", "one run is proposed")
    check(tab.text(".split-runs tbody td[data-label=Press]") == "1", "with its press")
    tab.js(f"(() => {{ document.getElementById('cut-at').value = '1.25'; {ADD_CUT}; }})()")
    tab.wait("document.querySelectorAll('.split-runs tbody tr').length === 2", "a cut makes two runs")
    check(cut_us(tab) == [1_250_000], f"the cut is at {cut_us(tab)}")
    left, top, width, height = tab.box(".cut")
    tab.drag(left + width / 2, top + height / 2, left + width / 2 + 60)
    dragged = cut_us(tab)
    check(dragged[0] > 1_260_000, f"it is dragged to {dragged}")
    tab.js("document.querySelector('.cut').focus()")
    tab.key("ArrowLeft")
    check(cut_us(tab) == [dragged[0] - 10_000], "a key moves it by 10 ms")
    check(tab.js("document.activeElement.matches('.cut')"), "and it keeps the focus")
    area = tab.box(".cut-lines")
    tab.js(
        f"document.querySelector('.cut-lines').dispatchEvent(new MouseEvent('dblclick', {{clientX: {area[0] + 0.8 * area[2]}, bubbles: true}}))"
    )
    tab.wait("document.querySelectorAll('.cut').length === 2", "a double click adds one")
    tab.click("[data-key=remove-2]")
    tab.wait("document.querySelectorAll('.cut').length === 1", "and its button removes it")
    tab.js("[...document.querySelectorAll('button')].find(b => b.textContent === 'Propose again').click()")
    tab.js("location.hash = '#/'")
    tab.wait("document.querySelectorAll('tbody tr').length === 2", "one can leave while cuts are proposed")
    tab.go(world.server.url + f"#/split/{RUN}")
    tab.wait("document.querySelectorAll('.split-runs tbody tr').length === 1", "and come back")
    tab.js(f"(() => {{ document.getElementById('cut-at').value = '{dragged[0] / 1e6}'; {ADD_CUT}; }})()")
    check(tab.text("[data-key=write]") == "Write 2 runs", tab.text("[data-key=write]"))
    tab.js("(() => { document.getElementById('objects').value = '../fan'; })()")
    tab.click("[data-key=write]")
    tab.wait("/is no name of an object/.test(document.getElementById('message').textContent)", "a wrong name is refused")
    check(not os.path.exists(world.pieces), "and nothing is written")
    tab.js("(() => { document.getElementById('objects').value = 'mug'; })()")
    tab.click("[data-key=write]")
    tab.wait("/^2 runs in .*mug.01, mug.02/.test(document.querySelector('.written')?.textContent)", "the runs are written")
    check(os.path.exists(os.path.join(world.pieces, "mug", "02", "events.aedat4")), "they are there")
    world.quiet("cutting a recording")
    tab.close()


def zooms_on_cuts(world):
    tab = Tab(world.browser)
    tab.go(world.server.url + f"#/split/{RUN}")
    tab.wait("document.querySelector('.cut-area canvas') && document.querySelector('.cut-area').dataset.to_us", "the cuts are shown")
    seen = lambda: tab.js("(({from_us, to_us}) => [Number(from_us), Number(to_us)])(document.querySelector('.cut-area').dataset)")  # noqa: E731
    whole = seen()
    tab.js(f"(() => {{ document.getElementById('cut-at').value = '1.25'; {ADD_CUT}; }})()")
    left, top, width, height = tab.box(".cut-lines")
    for _ in range(30):
        tab.wheel(left + width * 0.4, top + 60, -300)
    check(seen()[1] - seen()[0] == 1000, f"the wheel zooms to a millisecond; it shows {seen()}")
    under = 0.4 * whole[1]
    check(abs(sum(seen()) / 2 - under) < 0.02 * whole[1], "the time under the pointer stays")
    check(tab.js("document.querySelector('.cut').classList.contains('outside')"), "the cut is outside")
    tab.js("document.querySelector('.cut').focus()")
    check(seen()[0] <= 1_250_000 <= seen()[1], f"a cut that gets the focus is shown; it shows {seen()}")
    tab.key("ArrowRight")
    check(cut_us(tab)[0] == 1_250_010, f"a key moves it by a hundredth of the axis, to {cut_us(tab)}")
    before = seen()
    tab.drag(left + width * 0.8, top + 60, left + width * 0.3)
    check(abs(seen()[0] - before[0] - 500) <= 2, f"a drag moves the axis: {before} became {seen()}")
    tab.wait(
        "performance.getEntriesByType('resource').some(r => { const q = new URL(r.name).searchParams;"
        " return r.name.includes('/signals') && q.get('to_us') - q.get('from_us') <= 4000; })", "the rate of the few milliseconds is loaded"
    )
    tab.js("document.activeElement.blur()")
    tab.key("-")
    check(seen()[1] - seen()[0] == 2000, "a key shows twice as much")
    tab.key("?")
    tab.wait("/A cut that has the focus/.test(document.querySelector('dialog')?.textContent)", "? shows the keys of cuts")
    tab.key("Escape")
    tab.key("0")
    check(seen() == whole, "0 shows all")
    tab.drag(left + width * 0.25, top + 60, left + width * 0.5, SHIFT)
    check(abs((seen()[1] - seen()[0]) / whole[1] - 0.25) < 0.01, "Shift and drag zooms to a stretch")
    world.quiet("zooming on cuts")
    tab.close()


def is_sound_on_every_screen(world):
    for width, dark in ((1280, False), (1280, True), (390, False), (390, True)):
        for name, address, ready in PAGES:
            tab = Tab(world.browser, width, dark)
            tab.go(world.server.url + address)
            tab.wait(ready, f"{name} is shown")
            if name == "split":
                tab.wait("performance.getEntriesByType('resource').some(r => r.name.includes('/signals') && r.responseEnd > 0)", "with its rate")
            tab.wait(
                "[...document.querySelectorAll('.strip .value')].every(e => e.textContent || e.closest('.compare, .cut-area'))", "signals are there"
            )
            look = f"{name}, {width} px, {'dark' if dark else 'light'}"
            problems = problems_of(tab, width, dark, world.axe)
            if name == "run":
                tab.js("document.activeElement.blur()")
                tab.key("?")
                tab.wait("document.querySelector('dialog .keys')", "? shows the keys")
                problems += [f"help: {words}" for words in problems_of(tab, width, dark, world.axe)]
                tab.key("Escape")
            tab.picture(os.path.join(world.home, f"{name}-{width}{'-dark' if dark else ''}.png"))
            if (width, dark) == (1280, False):
                problems += unreachable(tab)
            check(not problems, f"{look}: " + "; ".join(problems))
            world.quiet(look)
            tab.close()
    tab = Tab(world.browser, 390)
    tab.go(world.server.url)
    tab.wait("document.querySelector('main .count')", "the list is there")
    tab.js("document.querySelector('main').append(Object.assign(document.createElement('button'), {className: 'wide'}))")
    tab.js(
        "Object.assign(document.querySelector('button.wide').style, {width: '900px', maxWidth: 'none', color: 'gray', background: 'gray'})"
    )
    found = "; ".join(problems_of(tab, 390, True))
    for words in ("wider than the screen", "a button without a name", "expected light on dark"):
        check(words in found, f"a broken page: '{words}' was not found, only: {found}")
    world.browser.events = []
    tab.close()
