const MOST_NAMED = 3;

// What is current at the cursor, in words; at most ten times a second.
function beginNow() {
  const parts = Object.fromEntries(
    [...document.querySelectorAll("[data-now]")].map((each) => [each.dataset.now, each]),
  );
  const line = (text, kind) => {
    const item = document.createElement("li");
    if (kind) {
      const key = document.createElement("span");
      key.className = `timeline-key is-${kind}`;
      key.setAttribute("aria-hidden", "true");
      item.append(key, " ");
    }
    item.append(text);
    return item;
  };
  // What does the same in a component stands in one line.
  const inUse = ({ component, always, elements }) => {
    if (always || !component) return [];
    const alike = new Map();
    for (const { name, state } of elements) alike.set(state, [...(alike.get(state) ?? []), name]);
    return [...alike].map(([state, names]) => [
      `${component}, ${stateWords(state)}: ${names.join(", ")}`,
      stateName(state),
    ]);
  };
  let last = "";
  function show() {
    const time = clock.time;
    const visit = visitAt(time);
    const all = activeAt(time);
    const active = all.flatMap(inUse);
    const always = all.filter((each) => each.always).map(({ component }) => component);
    if (always.length) active.push([`always in use: ${always.join(", ")}`, "in-use"]);
    const loose = all.find((each) => !each.always && !each.component)?.elements ?? [];
    if (loose.length) {
      const names = loose.slice(0, MOST_NAMED).map(({ name }) => name).join(", ");
      const more = loose.length > MOST_NAMED ? ` and ${loose.length - MOST_NAMED} more` : "";
      active.push([`in use and not counted, for the hardware data has no figure: ${names}${more}`, "in-use"]);
    }
    const touches = contactsAt(time).map(({ link, other, force, expected }) =>
      [`${link} touches ${other}, up to ${force.toFixed(1)} N`, expected ? "expected" : "unexpected"]);
    const held = visit < 0 ? [] : run.visits[visit].held.map(({ gripper, object, mass }) =>
      [`${gripper} holds ${object} in this visit (${mass} kg)`, null]);
    const now = JSON.stringify([visit, active, touches]);
    if (now === last) return;
    last = now;
    parts.function.textContent = visit < 0 ? betweenVisits(time) : functionOf(visit);
    parts.visit.textContent =
      visit < 0 ? "" : `visit ${visit + 1} of ${run.visits.length}, ${run.visits[visit].outcome}`;
    parts.active.replaceChildren(...active.map(([text, kind]) => line(text, kind)));
    parts.touching.replaceChildren(...[...touches, ...held].map(([text, kind]) => line(text, kind)));
  }
  let waiting = null;
  clock.subscribe(() => {
    waiting ??= setTimeout(() => {
      waiting = null;
      show();
    }, 100);
  });
  show();
}
