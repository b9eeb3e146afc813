// The sliders: each move asks the server, and the latest answer is shown.
const form = document.getElementById("what-if-form");
const inputs = [...form.querySelectorAll("[data-query]")];
const parts = Object.fromEntries(
  [...form.querySelectorAll("[data-answer]")].map((each) => [each.dataset.answer, each]),
);
const digits = (value, count) => Number(value.toPrecision(count)).toString();
const factorOf = (input) => digits(Number(input.dataset.base) ** Number(input.value), 3);

// What differs from how it is, as the server reads it.
function asked() {
  const query = new URLSearchParams();
  for (const input of inputs) {
    if (input.type !== "range") {
      if (input.value) query.set(input.dataset.query, input.value);
    } else if (factorOf(input) !== "1") query.set(input.dataset.query, factorOf(input));
  }
  return query;
}

function showInputs() {
  for (const input of inputs) {
    if (input.type !== "range") continue;
    const text = `x${factorOf(input)}`;
    input.nextElementSibling.textContent = text;
    input.setAttribute("aria-valuetext", text);
  }
}

const lines = (list, texts) =>
  list.replaceChildren(
    ...texts.map((text) => {
      const item = document.createElement("li");
      item.textContent = text;
      return item;
    }),
  );
const probability = (value) =>
  value > 0 && value < 1e-3 ? value.toExponential(3).replace("e-", "e-0").replace(/e-0(\d\d)/, "e-$1") : digits(value, 4);

function showAnswer(found) {
  form.classList.toggle("is-refused", Boolean(found.error));
  parts.after.textContent = found.error ?? probability(found.after);
  const isSame = found.error || found.after === found.before;
  parts.ratio.textContent = found.error
    ? ""
    : isSame
      ? "as it is"
      : `${found.ratio === null ? "" : `x${digits(found.ratio, 3)} of `}${probability(found.before)}`;
  lines(
    parts.components,
    (found.components ?? []).slice(0, 5).map(({ name, share }) =>
      `${name}: ${share > 0 && share < 1e-4 ? "< 0.01" : digits(100 * share, 3)} % of it`),
  );
  parts.command.textContent = found.command ?? "";
  lines(parts.assumptions, found.assumptions ?? []);
}

let number = 0;
let waiting = null;
async function ask() {
  waiting = null;
  const mine = ++number;
  const query = asked().toString();
  history.replaceState(null, "", query ? `?${query}${location.hash}` : location.pathname + location.hash);
  let found;
  try {
    const reply = await fetch(query ? `${form.dataset.address}?${query}` : form.dataset.address);
    found = await reply.json();
  } catch {
    found = { error: "no answer: is `tracerisk serve` still running?" };
  }
  if (mine === number) showAnswer(found);
}
function change() {
  showInputs();
  waiting ??= setTimeout(ask, 40);
}
form.addEventListener("input", change);
form.addEventListener("reset", () => setTimeout(change, 0));
form.addEventListener("submit", (event) => event.preventDefault());

// A link holds the values; what it does not hold stays as it is.
const given = new URLSearchParams(location.search);
for (const input of inputs) {
  const value = given.get(input.dataset.query);
  if (value === null) continue;
  if (input.type === "range") input.value = Math.log(Number(value)) / Math.log(Number(input.dataset.base));
  else input.value = value;
}
showInputs();
ask();
