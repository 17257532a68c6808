"""What makes a page of `tactile review` hard to read or to use, found in a browser. Each check returns problems in words."""

import json
import os

HERE = os.path.dirname(os.path.abspath(__file__))


def layout_problems(seen, width, dark):
    problems = []
    if seen["viewport"] != width:
        problems.append(f"the page is {seen['viewport']} px wide; it does not follow the screen")
    if seen["scroll"] > seen["viewport"] or seen["wide"]:
        problems.append(f"{seen['scroll']} px are wider than the screen's {seen['viewport']}: {seen['wide'][:4]}")
    if seen["cut"]:
        problems.append(f"text is cut: {seen['cut'][:4]}")
    if seen["overlapping"]:
        problems.append(f"controls overlap: {seen['overlapping'][:4]}")
    paper, ink = seen["brightness"]
    if (paper < ink) != dark:
        problems.append(f"brightness {ink:.2f} on {paper:.2f}; expected {'light on dark' if dark else 'dark on light'}")
    return problems


def access_problems(seen):
    problems = []
    if seen["faint"]:
        problems.append(f"contrast below 4.5: {seen['faint'][:6]}")
    for what, expected in (("mains", 1), ("heads", 1), ("navs", 1), ("images", 0), ("headless", 0)):
        if seen[what] != expected:
            problems.append(f"{seen[what]} {what}; expected {expected}")
    if seen["unlabelled"] or seen["twice"]:
        problems.append(f"fields without a label: {seen['unlabelled'][:4]}; ids that are not unique: {seen['twice'][:4]}")
    if seen["lang"] != "en" or not seen["title"]:
        problems.append(f"lang '{seen['lang']}', title '{seen['title']}'")
    return problems


CONTROLS = {"button", "link", "textbox", "searchbox", "combobox", "checkbox", "slider", "dialog", "progressbar"}


def nameless_controls(tab):
    """Controls that a screen reader cannot name, by the browser's own accessibility tree."""
    tab.browser.ask("Accessibility.enable", tab.session)
    problems = []
    for node in tab.browser.ask("Accessibility.getFullAXTree", tab.session)["nodes"]:
        role = node.get("role", {}).get("value")
        if not node.get("ignored") and role in CONTROLS and not node.get("name", {}).get("value", "").strip():
            problems.append(f"a {role} without a name")
    return problems


def axe_problems(tab, script):
    """The serious and critical findings of axe-core, whose script is given."""
    tab.js(script + "; 0")
    report = json.loads(tab.js("axe.run(document, {resultTypes: ['violations']}).then(r => JSON.stringify(r.violations))"))
    return [
        f"{v['id']} ({v['impact']}): {v['help']}: {[n['target'] for n in v['nodes']][:4]}"
        for v in report
        if v["impact"] in ("serious", "critical")
    ]


def problems_of(tab, width, dark, axe=None):
    with open(os.path.join(HERE, "look.js"), encoding="utf-8") as file:
        seen = json.loads(tab.js(file.read()))
    return layout_problems(seen, width, dark) + access_problems(seen) + nameless_controls(tab) + (axe_problems(tab, axe) if axe else [])


# A name that stays when a part of the page is drawn again.
NAME = "(e => [e.tagName, e.dataset.key ?? e.id, e.getAttribute('aria-label') ?? (e.matches('input, select') ? '' : e.textContent.trim())].join(' '))"

TABBABLE = """JSON.stringify([...document.querySelectorAll('a[href], button, input, select, textarea, summary, [tabindex="0"]')]
  .filter(e => !e.disabled && e.checkVisibility({checkVisibilityCSS: true})).map(%s))""" % NAME

FOCUSED = (
    """(() => { const e = document.activeElement, s = getComputedStyle(e);
  return JSON.stringify({name: e === document.body ? null : %s(e), ring: s.outlineStyle !== 'none' && parseFloat(s.outlineWidth) >= 2}); })()"""
    % NAME
)


def unreachable(tab):
    """Controls that Tab does not reach, and those where one does not see that they have the focus."""
    wanted = set(json.loads(tab.js(TABBABLE)))
    reached, problems = set(), []
    for _ in range(2 * len(wanted) + 20):
        tab.key("Tab")
        focus = json.loads(tab.js(FOCUSED))
        if focus["name"] is None:
            continue
        if not focus["ring"] and focus["name"] not in reached:
            problems.append(f"no visible focus on {focus['name']}")
        reached.add(focus["name"])
    return problems + [f"Tab does not reach {name}" for name in sorted(wanted - reached)]
