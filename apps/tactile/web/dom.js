// Making elements. Text is always set as text: no name of a run, an object or a flag can become markup.

/// el("button", {class: "small", onclick: f, "aria-label": "Play"}, "text", child, …). A value of false, null or undefined leaves the
/// attribute out; true sets it without a value. `style` is an object of properties.
export function el(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name === "style") Object.assign(element.style, value);
    else if (name === "value") element.value = value;
    else element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined && child !== false));
  return element;
}

/// A table of figures: `heads` are the words above its columns.
export function figuresTable(caption, heads, rows) {
  const columns = heads.map((words) => el("th", { scope: "col" }, words));
  return el("table", { class: "figures" }, el("caption", {}, caption), el("thead", {}, el("tr", {}, columns)), el("tbody", {}, rows));
}

/// Replaces what is in `container`. The element with the same data-key has the focus afterwards, as far as there is one.
export function refill(container, ...children) {
  const key = container.contains(document.activeElement) ? document.activeElement.dataset.key : null;
  container.replaceChildren(...children.flat(Infinity).filter(Boolean));
  if (key) container.querySelector(`[data-key="${CSS.escape(key)}"]`)?.focus({ preventScroll: true });
}

let quiet = null;
const MODIFIERS = ["Shift", "Control", "Alt", "Meta"];

/// Empties the line of messages.
export function endMessage(event) {
  if (MODIFIERS.includes(event?.key)) return;
  clearTimeout(quiet);
  for (const act of ["keydown", "pointerdown"]) removeEventListener(act, endMessage, true);
  document.getElementById("message").textContent = "";
}

/// A message at the bottom of the window, which a screen reader reads. It goes after some seconds. What answers to an act of the person goes
/// with the next act, which may make it untrue; what came by itself is `news`, and stays.
export function announce(words, kind = "note", { news = false } = {}) {
  endMessage();
  const line = document.getElementById("message");
  line.textContent = words; // it stays in the document while it is empty: a screen reader reads only what changes in it
  line.dataset.kind = kind;
  quiet = setTimeout(endMessage, kind === "error" ? 15000 : 6000);
  if (!news) for (const act of ["keydown", "pointerdown"]) addEventListener(act, endMessage, true);
}

/// A modal dialog. `buttons` are [{words, value, kind}]; the promise gives the value of the one that was pressed, or null for Escape. Enter in a
/// line of text presses the primary one, which does nothing while a field is not valid.
export function ask(title, content, buttons) {
  return new Promise((resolve) => {
    const dialog = el(
      "dialog",
      { "aria-labelledby": "dialog-title" },
      el("h2", { id: "dialog-title", tabindex: -1, autofocus: !content.querySelector("[autofocus]") }, title),
      content,
      el(
        "p",
        { class: "buttons" },
        buttons.map(({ words, value, kind, disabled }) =>
          el(
            "button",
            {
              type: "button",
              class: kind,
              disabled,
              "data-value": String(value),
              onclick: () => {
                if (kind === "primary" && ![...dialog.querySelectorAll("input, textarea")].every((field) => field.reportValidity())) return;
                dialog.returnValue = "done";
                answer = value;
                dialog.close();
              },
            },
            words,
          ),
        ),
      ),
    );
    let answer = null;
    dialog.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" || event.isComposing || !event.target.matches("input[type=text]")) return;
      event.preventDefault();
      dialog.querySelector("button.primary")?.click();
    });
    dialog.addEventListener("close", () => {
      dialog.remove();
      resolve(answer);
    });
    document.body.append(dialog);
    dialog.showModal();
  });
}

export function dialogIsOpen() {
  return document.querySelector("dialog[open]") !== null;
}

/// A button of a mouse gives the focus back, so that the keys of the page still work; by keyboard it keeps it.
export function button(words, onclick, attributes = {}) {
  return el(
    "button",
    {
      type: "button",
      ...attributes,
      onclick: (event) => {
        if (event.detail > 0) event.currentTarget.blur();
        onclick(event);
      },
    },
    words,
  );
}

/// A colour of style.css, as it is in light or dark.
export function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

export const darkScheme = matchMedia("(prefers-color-scheme: dark)");
