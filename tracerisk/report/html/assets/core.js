// What every part of the page shares: data, the clock, what is selected, the theme.
const probe = document.body.appendChild(document.createElement("span"));
probe.hidden = true;

// Time, and who follows it. The page has one clock; what shows more than its run makes others.
function makeClock() {
  const listeners = new Set();
  const clock = {
    time: 0,
    end: 0,
    set(time, source = null) {
      const held = Math.min(Math.max(Number(time) || 0, 0), clock.end);
      if (held === clock.time) return;
      clock.time = held;
      for (const listener of [...listeners]) listener(held, source);
    },
    setEnd(end) {
      clock.end = Math.max(Number(end) || 0, 0);
      if (clock.time > clock.end) clock.set(clock.end);
    },
    subscribe(listener) {
      listeners.add(listener);
      listener(clock.time, null);
      return () => listeners.delete(listener);
    },
  };
  return clock;
}

const tracerisk = {
  clock: makeClock(),
  makeClock,
  selected: { function: null, component: null },
  data(id) {
    return JSON.parse(document.getElementById(id).textContent);
  },
  bytes(id) {
    const text = atob(document.getElementById(id).textContent.trim());
    return Uint8Array.from(text, (character) => character.charCodeAt(0));
  },
  colour(name) {
    // A variable may hold one colour for each theme; an element shows which of them it is.
    probe.style.color = `var(--${name})`;
    return getComputedStyle(probe).color;
  },
  select({ function: name = null, component = null, source = null } = {}) {
    const same =
      tracerisk.selected.function === name && tracerisk.selected.component === component;
    if (same) return;
    tracerisk.selected = { function: name, component };
    const detail = { function: name, component, source };
    document.dispatchEvent(new CustomEvent("tracerisk:select", { detail }));
  },
};
window.tracerisk = tracerisk;

// An element fits when nothing that it names differs from what is chosen, and something is equal.
function fits(element, chosen) {
  const { function: name, component } = element.dataset;
  if (name === undefined && component === undefined) return false;
  const agrees = (own, wanted) => own === undefined || wanted === null || own === wanted;
  const equal = (own, wanted) => own !== undefined && own === wanted;
  return (
    agrees(name, chosen.function) &&
    agrees(component, chosen.component) &&
    (equal(name, chosen.function) || equal(component, chosen.component))
  );
}

document.addEventListener("tracerisk:select", (event) => {
  const chosen = event.detail;
  const isAny = chosen.function !== null || chosen.component !== null;
  document.documentElement.classList.toggle("has-selection", isAny);
  for (const element of document.querySelectorAll("[data-function], [data-component]")) {
    const isChosen = isAny && fits(element, chosen);
    element.classList.toggle("is-selected", isChosen);
    if (element.hasAttribute("aria-pressed")) element.setAttribute("aria-pressed", isChosen);
  }
});

// Drawings can be clicked too; with the keyboard, the buttons in the tables do the same.
const choices = ["button", ".drawing "]
  .flatMap((where) => [`${where}[data-function]`, `${where}[data-component]`])
  .join(", ");

document.addEventListener("click", (event) => {
  const found = event.target.closest(choices);
  if (!found) return;
  const chosen = {
    function: found.dataset.function ?? null,
    component: found.dataset.component ?? null,
  };
  const isSame =
    tracerisk.selected.function === chosen.function &&
    tracerisk.selected.component === chosen.component;
  tracerisk.select(isSame ? { source: "button" } : { ...chosen, source: "button" });
});

document.addEventListener("keydown", (event) => {
  if (event.key === "Escape") tracerisk.select({ source: "keyboard" });
});

// Paper has nothing to unfold; what would fill pages and is drawn as well stays folded.
let folded = [];
let shownTheme;
addEventListener("beforeprint", () => {
  // Pictures are drawn in the colours of paper before the page is.
  shownTheme = root.dataset.theme;
  root.dataset.theme = "light";
  announceTheme();
  folded = [...document.querySelectorAll("details:not([open], [data-print=folded])")];
  for (const each of folded) each.open = true;
});
addEventListener("afterprint", () => {
  for (const each of folded) each.open = false;
  if (shownTheme === undefined) delete root.dataset.theme;
  else root.dataset.theme = shownTheme;
  announceTheme();
});

// What a link leads to may be folded.
function unfold() {
  const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
  for (let each = target?.closest("details"); each; each = each.parentElement.closest("details")) {
    each.open = true;
  }
  target?.scrollIntoView();
}
addEventListener("hashchange", unfold);
if (location.hash) unfold();

// What is wider than the window says so below itself, for a scroll bar may be hidden.
const widths = new ResizeObserver((entries) => {
  for (const { target } of entries) {
    const isWide = target.scrollWidth > target.clientWidth + 1;
    const next = target.nextElementSibling;
    const cue = next?.classList.contains("more-sideways") ? next : null;
    if (!isWide) cue?.remove();
    else if (!cue) {
      const more = document.createElement("span");
      more.className = "more-sideways";
      more.setAttribute("aria-hidden", "true");
      more.textContent = "\u2194 scroll sideways for more";
      target.after(more);
    }
  }
});
for (const each of document.querySelectorAll(".scroll")) widths.observe(each);

const root = document.documentElement;
const themes = ["auto", "light", "dark"];
const dark = matchMedia("(prefers-color-scheme: dark)");
const announceTheme = () => document.dispatchEvent(new CustomEvent("tracerisk:theme"));

function showTheme(theme) {
  if (theme === "auto") delete root.dataset.theme;
  else root.dataset.theme = theme;
  for (const button of document.querySelectorAll("[data-theme-choice]")) {
    button.setAttribute("aria-pressed", button.dataset.themeChoice === theme);
  }
  announceTheme();
}

dark.addEventListener("change", announceTheme);
document.addEventListener("click", (event) => {
  const button = event.target.closest("[data-theme-choice]");
  if (!button) return;
  showTheme(button.dataset.themeChoice);
  try {
    localStorage.setItem("tracerisk-theme", button.dataset.themeChoice);
  } catch {
    // A page from a file may have no storage; the choice then holds for this visit.
  }
});
let kept = null;
try {
  kept = localStorage.getItem("tracerisk-theme");
} catch {
  kept = null;
}
showTheme(themes.includes(kept) ? kept : "auto");
