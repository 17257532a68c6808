// What a reader would stumble over on the page that is shown, as JSON. Contrast by the formula of WCAG 2.1: text on what its nearest opaque
// ancestor has as background. Run in the page by page_checks.py.
(() => {
  const root = document.documentElement;
  const rgba = (c) => {
    const n = c.match(/[\d.]+/g).map(Number);
    return [n[0], n[1], n[2], n.length > 3 ? n[3] : 1];
  };
  const light = ([r, g, b]) =>
    [r, g, b]
      .map((v) => v / 255)
      .map((v) => (v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4))
      .reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0);
  const under = (e) => {
    for (; e; e = e.parentElement) {
      const c = rgba(getComputedStyle(e).backgroundColor);
      if (c[3] === 1) return c;
    }
    return [255, 255, 255, 1];
  };
  const seen = (e) => e.checkVisibility({ checkOpacity: true, checkVisibilityCSS: true }) && !e.closest(".hidden, .skip");
  const wide = [],
    faint = [],
    cut = [];
  for (const e of document.body.querySelectorAll("*")) {
    if (!seen(e)) continue;
    const box = e.getBoundingClientRect(),
      words = [...e.childNodes]
        .filter((n) => n.nodeType === 3)
        .map((n) => n.textContent.trim())
        .join("");
    if (box.width && (box.right > root.clientWidth + 1 || box.left < -1) && !e.closest(".scroll, .surface, .overview, .chart"))
      wide.push(e.tagName + "." + e.className + " " + words.slice(0, 30));
    if (!words) continue;
    const style = getComputedStyle(e),
      paper = under(e);
    const [a, b] = [light(rgba(style.color)), light(paper)].sort((x, y) => y - x);
    const ratio = (a + 0.05) / (b + 0.05);
    if (ratio < 4.5) faint.push(`${ratio.toFixed(2)} ${e.tagName}.${e.className} "${words.slice(0, 30)}"`);
    if (
      e.closest("button, th, td, h1, h2, p, li") === e &&
      style.overflow === "hidden" &&
      e.scrollWidth > e.clientWidth + 1 &&
      !e.closest(".strip")
    )
      cut.push(words.slice(0, 40));
  }
  const buttons = [...document.querySelectorAll("button, select, input")].filter(seen).filter((e) => !e.closest(".surface"));
  const overlapping = [];
  for (const [i, a] of buttons.entries())
    for (const b of buttons.slice(i + 1)) {
      const [x, y] = [a.getBoundingClientRect(), b.getBoundingClientRect()];
      if (
        a.closest("dialog") === b.closest("dialog") &&
        Math.min(x.right, y.right) - Math.max(x.left, y.left) > 1 &&
        Math.min(x.bottom, y.bottom) - Math.max(x.top, y.top) > 1
      )
        overlapping.push(`"${a.textContent || a.id}" and "${b.textContent || b.id}"`);
    }
  return JSON.stringify({
    viewport: root.clientWidth,
    scroll: root.scrollWidth,
    wide,
    faint,
    cut,
    overlapping,
    mains: document.querySelectorAll("main").length,
    heads: document.querySelectorAll("h1").length,
    navs: document.querySelectorAll("nav[aria-label]").length,
    lang: root.lang,
    title: document.title,
    brightness: [light(rgba(getComputedStyle(root).backgroundColor)), light(rgba(getComputedStyle(root).color))],
    unlabelled: [...document.querySelectorAll("input, select, textarea")]
      .filter((e) => seen(e) && !e.labels?.length && !e.getAttribute("aria-label"))
      .map((e) => e.outerHTML.slice(0, 80)),
    twice: [...document.querySelectorAll("[id]")].map((e) => e.id).filter((id, i, ids) => ids.indexOf(id) !== i),
    images: [...document.images].filter((i) => i.getAttribute("alt") === null).length,
    headless: [...document.querySelectorAll("table")].filter((t) => !t.querySelector("th") || !t.caption).length,
  });
})();
