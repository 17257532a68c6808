#!/usr/bin/env python3
"""Looks at the report's page in a real browser, wide and narrow, light and dark.

    report_page_test.py TACTILE [--keep FOLDER]

Ends with 77 where there is no Chromium. --keep keeps study, report and
screenshots.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path += [HERE, os.path.join(HERE, "..", "support")]
from browser import Browser, chromium  # noqa: E402
from made_study import write_model, write_study  # noqa: E402

SMALLEST_WORDS_PX = 7.5  # on a phone, whose pixels are finer than those of CSS
HOSTILE = " <b onerror=alert(1)>\"quoted\" & 'single'</b><script>document.title='x'</script>"
STUDY_FIGURES = {"settings-curve", "operating-curve-stream", "operating-curve-stream-unseen", "operating-curve-th040",
                 "operating-curve-th040-unseen", "accuracy-by-history", "run-water-bottle-04-th040-01-s501", "training"}
MODEL_FIGURES = {"operating-curve", "delays", "confusion", "reliability", "run-water-bottle-04-model", "unseen", "training"}

LOOK = """(() => {
  const root = document.documentElement;
  const folded = [...document.querySelectorAll('details:not([open])')];
  const foldedFigures = folded.reduce((n, d) => n + d.querySelectorAll('figure').length, 0);
  folded.forEach(d => { d.open = true; });  // what is folded must be as sound as the rest
  const wide = [];
  for (const e of document.body.querySelectorAll('*')) {
    const box = e.getBoundingClientRect();
    if (box.right > root.clientWidth + 1 && !e.closest('.scroll')) wide.push(e.tagName + ' ' + e.textContent.trim().slice(0, 40));
  }
  return JSON.stringify({
    title: document.title,
    viewport: root.clientWidth, scroll: root.scrollWidth, wide: wide,
    figures: [...document.querySelectorAll('figure')].map(f => {
      const svg = f.querySelector('svg'), box = svg ? svg.getBoundingClientRect() : {};
      const words = svg ? [...svg.querySelectorAll('text')].filter(t => t.textContent.trim()) : [];
      const cut = words.filter(t => { const b = t.getBoundingClientRect();
        return b.left < box.left - 1 || b.right > box.right + 1 || b.top < box.top - 1 || b.bottom > box.bottom + 1; });
      return {id: f.id, width: svg ? svg.viewBox.baseVal.width : 0, shown: box.width || 0, right: box.right || 0, words: words.length,
        cut: cut.map(t => t.textContent.trim().slice(0, 40)),
        least: Math.min(...words.map(t => parseFloat(t.parentElement.getAttribute('font-size')) * box.width / svg.viewBox.baseVal.width)),
        ink: words.length ? getComputedStyle(words[0]).fill : '',
        colours: svg ? [...new Set(svg.outerHTML.match(/rgb\([^)]*\)/g) || [])] : [],
        alt: svg ? svg.getAttribute('aria-label') : '', caption: f.querySelector('figcaption') ? f.querySelector('figcaption').textContent : ''}; }),
    twice: [...document.querySelectorAll('[id]')].map(e => e.id).filter((id, i, all) => all.indexOf(id) !== i),
    tables: [...document.querySelectorAll('table')].map(t => ({caption: t.caption ? t.caption.textContent : '',
      wide: t.parentElement.scrollWidth > t.parentElement.clientWidth + 1,
      rows: t.tBodies.length ? t.tBodies[0].rows.length : 0, ragged: [...t.rows].some(r => r.cells.length !== t.rows[0].cells.length)})),
    anchors: [...document.querySelectorAll('a[href^="#"]')].filter(a => !document.getElementById(a.hash.slice(1))).map(a => a.hash),
    folded: folded.length, foldedFigures: foldedFigures,
    links: document.querySelectorAll('nav a').length,
    scripts: document.scripts.length,
    marked: document.querySelectorAll('b, script, [onerror]').length,
    background: getComputedStyle(document.body).backgroundColor, ink: getComputedStyle(document.body).color,
    words: document.body.innerText.length})
})()"""


def look_at(browser, page, width, dark, picture):
    """What is on the page, the requests that it made, and what the console showed."""
    target, session = browser.open(width, dark)
    browser.ask("Page.navigate", session, url="file://" + os.path.abspath(page))
    browser.wait_for("Page.loadEventFired", session)
    seen = json.loads(browser.evaluate(session, LOOK))
    browser.screenshot(session, picture, captureBeyondViewport=True,
                       clip={"x": 0, "y": 0, "width": width, "height": 12000 if width < 600 else 9000, "scale": 0.5 if width < 600 else 1})
    requests = [e["params"]["request"]["url"] for e in browser.events if e.get("method") == "Network.requestWillBeSent"]
    complaints = [words[:300] for words in browser.complaints()]
    browser.ask("Target.closeTarget", targetId=target)
    return seen, requests, complaints


def problems_with(seen, requests, complaints, page, figures):
    """Whatever a reader would stumble over, in words."""
    problems = []
    ids = [figure["id"] for figure in seen["figures"]]
    for name in figures:
        if "figure-" + name not in ids:
            problems.append(f"figure {name} is not on the page")
    for figure in seen["figures"]:
        if figure["width"] <= 0 or figure["shown"] <= 0 or figure["words"] < 3:
            problems.append(f"{figure['id']} is not drawn")
            continue
        if figure["cut"] or figure["right"] > seen["viewport"] + 1:
            problems.append(f"{figure['id']} is cut: {figure['cut'][:3]}")
        if figure["least"] < SMALLEST_WORDS_PX:
            problems.append(f"{figure['id']} has words of {figure['least']:.1f} px")
        if abs(brightness(figure["ink"]) - brightness(seen["background"])) < 100:
            problems.append(f"{figure['id']} cannot be read on the page: {figure['ink']} on {seen['background']}")
        if figure["colours"]:
            problems.append(f"{figure['id']} has colours that do not follow the page: {figure['colours'][:3]}")
        if len(figure["caption"]) < 20 or len(figure["alt"]) < 20:
            problems.append(f"{figure['id']} is not described in words")
    for table in seen["tables"]:
        if table["rows"] == 0 or table["ragged"]:
            problems.append(f"table '{table['caption']}' is empty or ragged")
        if table["wide"] and seen["viewport"] >= 1280:
            problems.append(f"table '{table['caption']}' is wider than the page")
    if seen["twice"]:
        problems.append(f"ids that are not unique: {seen['twice'][:3]}")
    if not seen["tables"]:
        problems.append("there is no table")
    if seen["scroll"] > seen["viewport"] or seen["wide"]:
        problems.append(f"{seen['scroll']} px are wider than the page's {seen['viewport']}: {seen['wide'][:3]}")
    if seen["scripts"] or seen["marked"]:
        problems.append(f"{seen['scripts']} scripts, {seen['marked']} elements that a name has made")
    if seen["anchors"] or seen["links"] < 3:
        problems.append(f"the contents lead nowhere: {seen['anchors']}")
    own = "file://" + os.path.abspath(page)
    for url in requests:
        if url.split("#")[0] != own and not url.startswith("data:"):
            problems.append(f"request to {url}")
    problems += [f"console: {words}" for words in complaints]
    return problems


def brightness(colour):
    return sum(int(part) for part in re.findall(r"\d+", colour)[:3]) / 3


def check(condition, words):
    if not condition:
        raise AssertionError(words)


def report_of(tactile, folder, figures):
    """What `tactile report` prints of a folder. It must draw these figures, among others."""
    result = subprocess.run([tactile, "report", folder, "--json", "--quiet"], capture_output=True, text=True)
    check(result.returncode == 0, f"tactile report ended with {result.returncode}: {result.stderr}")
    report = json.loads(result.stdout)
    check(figures <= set(report["figures"]), f"{folder}: only {report['figures']}")
    return report


def main():
    tactile = sys.argv[1]
    keep = sys.argv[sys.argv.index("--keep") + 1] if "--keep" in sys.argv else None
    binary = chromium()
    if not binary:
        print("SKIPPED LOUDLY: there is no Chromium; 'apt install chromium' or scripts/setup installs it")
        return 77
    home = keep or tempfile.mkdtemp(prefix="tactile-page-")
    os.makedirs(home, exist_ok=True)
    browser = None
    try:
        pages = {}
        for name, write, mark, figures in (
            ("plain", write_study, "", STUDY_FIGURES),
            ("hostile", write_study, HOSTILE, {"settings-curve", "training"}),
            ("model", write_model, HOSTILE, MODEL_FIGURES),
        ):
            pages[name] = report_of(tactile, write(os.path.join(home, name), mark), figures)
        browser = Browser(binary, home)
        for name, report in pages.items():
            for width, dark in ((1280, False), (1280, True), (390, False), (390, True)):
                look = f"{name}, {width} px, {'dark' if dark else 'light'}"
                picture = os.path.join(home, f"{name}-{width}{'-dark' if dark else ''}.png")
                seen, requests, complaints = look_at(browser, report["page"], width, dark, picture)
                problems = problems_with(seen, requests, complaints, report["page"], report["figures"])
                check(not problems, f"{look}: " + "; ".join(problems))
                check(seen["viewport"] == width, f"{look}: the page is {seen['viewport']} px wide; it does not follow the screen")
                check(seen["title"] == report["title"], f"{look}: title {seen['title']}")
                check((brightness(seen["background"]) < brightness(seen["ink"])) == dark, f"{look}: {seen['ink']} on {seen['background']}")
                check(seen["folded"] >= 10 and seen["foldedFigures"] == 0,
                      f"{look}: {seen['folded']} folds with {seen['foldedFigures']} figures; only tables are folded")
                print(f"ok  {look}: {len(seen['figures'])} figures, {len(seen['tables'])} tables")

        # The same eyes must see what is wrong with a page that is.
        page = pages["plain"]["page"]
        html = open(page, encoding="utf-8").read()
        broken = os.path.join(home, "broken.html")
        with open(broken, "w", encoding="utf-8") as file:
            html = re.sub(r'<meta http-equiv="Content-Security-Policy"[^>]*>', "", html)
            html = html.replace("<svg viewBox=", "<svg data-was=", 1)
            html = "rgb(1, 2, 3)".join(html.rsplit("var(--f1)", 1))
            first, second = html.split("<text>", 1)
            last = second.rindex("<text>")
            html = first + "<text>" + second[:last] + "<text x='900'>" + second[last + 6:]
            file.write(html.replace("</main>", "<div style='width:3000px'>wide</div><table><tbody></tbody></table>"
                                    "<img src='http://127.0.0.1:9/nothing.png'><script>console.error('x')</script></main>"))
        seen, requests, complaints = look_at(browser, broken, 390, False, os.path.join(home, "broken.png"))
        found = "; ".join(problems_with(seen, requests, complaints, broken, pages["plain"]["figures"] + ["not-there"]))
        for words in ("is not drawn", "is cut", "colours that do not follow", "is empty or ragged", "wider than the page", "1 scripts", "request to http://127.0.0.1:9", "console:",
                      "figure not-there is not on the page"):
            check(words in found, f"a broken page: '{words}' was not found, only: {found}")
        print("ok  a broken page is found to be one")
        return 0
    finally:
        if browser:
            browser.close()
        if not keep:
            shutil.rmtree(home, ignore_errors=True)


sys.exit(main())
