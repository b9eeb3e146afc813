// What the chart says of the place under the pointer, or of the visit that has the focus.

function visitTip(stretch) {
  if (!stretch) return null;
  const { visit, start, stop } = stretch;
  const { outcome, held } = run.visits[visit];
  const things = held.map(({ object, mass }) => `holds ${object} (${mass} kg)`);
  return [
    `${functionOf(visit)}, visit ${visit + 1}: ${secondsText(start)} to ${secondsText(stop)}`,
    outcome, ...things,
  ].join("; ");
}

function lineTip({ row, element, segments }, time) {
  const name = element?.name ?? (row.component || `elements ${NO_COMPONENT}`);
  if (row.always && !element) return `${name}: always in use`;
  const segment = at(segments, time);
  if (!segment) return `${name}: idle at ${secondsText(time)}`;
  const { start, stop, state } = segment;
  return `${name}: ${stateWords(state)}, ${secondsText(start)} to ${secondsText(stop)}`;
}

// The marks within a few pixels of a time.
function marksTip(time, reach) {
  const near = run.marks.filter((mark) => Math.abs(mark.time - time) <= reach);
  const parts = near.slice(0, 3).map(({ time: at, text }) => `${secondsText(at)}: ${text}`);
  if (near.length > 3) parts.push(`and ${near.length - 3} more`);
  return parts.length ? parts.join("; ") : null;
}

function showTip(text, left = 0, top = 0) {
  const tip = document.querySelector(".timeline-tip");
  tip.hidden = !text;
  if (!text) return;
  tip.textContent = text;
  const room = document.documentElement.clientWidth - tip.offsetWidth - 8;
  tip.style.left = `${Math.max(Math.min(left + 12, room), 4)}px`;
  tip.style.top = `${top + 18}px`;
}
