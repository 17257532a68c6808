// Begins the page: which part is shown, keys, and whether the server answers.

import { getRuns, getWho, keepToken, onConnection } from "./api.js";
import { announce, el, endMessage, refill } from "./dom.js";
import { Refused, Unreachable } from "./edit_queue.js";
import { ComparePage } from "./compare_page.js";
import { ModelsPage } from "./models_page.js";
import { StudiesPage } from "./studies_page.js";
import { RunPage } from "./run_page.js";
import { RunTable } from "./run_table.js";
import { SplitPage } from "./split_page.js";
import { routeOf } from "./router.js";

const PAGES = { runs: RunTable, run: RunPage, split: SplitPage, models: ModelsPage, compare: ComparePage, studies: StudiesPage };
const RETRY_MS = 2000;

let shown = null;
let failed = false; // the page that is shown could not begin

async function show() {
  const route = routeOf(location.hash);
  shown?.stop();
  const page = new PAGES[route.page](route);
  shown = page;
  failed = false;
  document.getElementById("main").replaceWith(page.element);
  document.title = `${page.title} – tactile review`;
  for (const link of document.querySelectorAll("nav a")) {
    const here = link.dataset.pages.split(" ").includes(route.page);
    if (here) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  }
  try {
    if (document.body.dataset.data === undefined) document.body.dataset.data = (await getRuns()).data;
    if (page === shown) await page.start();
  } catch (error) {
    if (page !== shown || error.name === "AbortError") return;
    failed = true;
    if (!(error instanceof Unreachable || error instanceof Refused)) console.error(error);
    refill(
      page.element,
      el("h1", {}, page.title),
      el("p", { class: "error", role: "alert" }, `This cannot be shown: ${error.message}.`),
      el("p", {}, el("button", { type: "button", onclick: show }, "Try again"), " ", el("a", { href: "#/" }, "All runs")),
    );
  }
}

function watchServer() {
  const banner = document.getElementById("lost");
  document.getElementById("try").addEventListener("click", () => getWho().catch(() => announce("Still no answer.", "error", { news: true })));
  onConnection((reachable) => {
    banner.hidden = reachable;
    if (!reachable) return;
    announce("The server answers again.", "note", { news: true });
    if (failed) show();
  });
  setInterval(() => {
    if (!banner.hidden) getWho().catch(() => {});
  }, RETRY_MS);
}

/// A choice by mouse gives the focus back, so that the keys of the page still work; by keyboard it keeps it.
function giveKeysBack() {
  let byPointer = false;
  addEventListener("pointerdown", () => {
    byPointer = true;
  });
  addEventListener("keydown", () => {
    byPointer = false;
  });
  addEventListener("change", ({ target }) => {
    if (byPointer && target.matches("select")) target.blur();
  });
}

keepToken();
watchServer();
addEventListener("hashchange", () => {
  endMessage(); // it was about another page
  show();
});
addEventListener("keydown", (event) => shown?.key?.(event));
giveKeysBack();
document.getElementById("skip").addEventListener("click", (event) => {
  event.preventDefault(); // the address after the # is the page's own
  document.getElementById("main").focus();
});
show();
