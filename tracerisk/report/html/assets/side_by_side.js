// Two runs side by side: one cursor on a common axis moves a clock for each of them.

const both = tracerisk.data("side-by-side");
const SIDES = ["before", "now"];
const runs = {
  before: tracerisk.openRun(both.before),
  now: tracerisk.shownRun,
};
const ends = SIDES.map((side) => runs[side].run.end);
const cursor = tracerisk.makeClock();
const clocks = { before: tracerisk.makeClock(), now: tracerisk.makeClock() };
SIDES.forEach((side, i) => clocks[side].setEnd(ends[i]));

// Where each stretch begins and ends on the axis on which the runs are in step [s].
let along = 0;
for (const stretch of both.stretches) {
  stretch.start = along;
  along += Math.max(...SIDES.map((side) => stretch[side][1] - stretch[side][0]));
  stretch.stop = along;
}
let isInStep = true;

// From a place of the cursor to the time of a run, and back.
function timeOf(side, place) {
  if (!isInStep) return place;
  const found = both.stretches.find(({ stop }) => place <= stop) ?? both.stretches.at(-1);
  if (!found) return 0;
  const share = (place - found.start) / (found.stop - found.start || 1);
  const [first, last] = found[side];
  return first + Math.min(Math.max(share, 0), 1) * (last - first);
}
function placeOf(side, time) {
  if (!isInStep) return time;
  const found = both.stretches.find((each) => time <= each[side][1] + 1e-6 && each[side][1] > each[side][0]);
  if (!found) return cursor.end;
  const [first, last] = found[side];
  return found.start + ((time - first) / (last - first)) * (found.stop - found.start);
}
// Both runs are at a difference at the later of the two places.
const placeOfDifference = ({ before, now }) =>
  isInStep ? Math.max(placeOf("before", before), placeOf("now", now)) : now;

const time = tracerisk.secondsText;
function whereText(side) {
  const own = clocks[side].time;
  const visit = runs[side].visitAt(own);
  return `${visit < 0 ? runs[side].betweenVisits(own) : runs[side].functionOf(visit)}, ${time(own)} of ${time(clocks[side].end)}`;
}

const root = document.querySelector(".side-by-side");
const slider = document.getElementById("side-slider");
const lanes = root.querySelector(".side-lanes");
const nows = Object.fromEntries(SIDES.map((side) => [side, root.querySelector(`[data-side-now="${side}"]`)]));
const jumps = [...root.querySelectorAll("[data-side-at]")];
const player = tracerisk.makePlayer(cursor, () => Number(document.getElementById("side-speed").value));

function drawLanes() {
  const part = (kind, start, stop) => {
    const span = document.createElement("span");
    span.className = `side-part is-${kind}`;
    span.style.left = `${(100 * start) / cursor.end}%`;
    if (stop !== undefined) span.style.width = `${(100 * (stop - start)) / cursor.end}%`;
    return span;
  };
  const rows = SIDES.map((side) => {
    const row = document.createElement("div");
    row.className = "side-lane";
    for (const stretch of both.stretches) {
      const [start, stop] = isInStep ? [stretch.start, stretch.stop] : stretch[side];
      if (stretch.kind === "other" || stretch.kind === side) row.append(part(stretch.kind, start, stop));
    }
    for (const difference of both.differences) {
      row.append(part("mark", isInStep ? placeOfDifference(difference) : difference[side]));
    }
    return row;
  });
  lanes.replaceChildren(...rows);
  // The instant of the present run, which the picture then says: the axis in step is longer.
  jumps.forEach((jump, i) => {
    jump.textContent = time(both.differences[i].now);
  });
}

function step(forward) {
  const places = both.differences.map(placeOfDifference).sort((one, other) => one - other);
  const wanted = forward
    ? places.find((place) => place > cursor.time + 1e-3)
    : places.findLast((place) => place < cursor.time - 1e-3);
  player.pause();
  cursor.set(wanted ?? (forward ? cursor.end : 0), "difference");
}

function align(inStep) {
  // The present run stays where it is.
  const own = clocks.now.time;
  isInStep = inStep;
  cursor.setEnd(inStep ? along : Math.max(...ends));
  slider.max = String(cursor.end);
  for (const button of root.querySelectorAll("[data-side-mode]")) {
    button.setAttribute("aria-pressed", (button.dataset.sideMode === "step") === inStep);
  }
  cursor.set(placeOf("now", own), "mode");
  drawLanes();
  follow(cursor.time, "mode");
}

function follow(place, source) {
  for (const side of SIDES) {
    clocks[side].set(timeOf(side, place), source);
    nows[side].textContent = whereText(side);
  }
  slider.value = String(place);
  slider.setAttribute("aria-valuetext", SIDES.map((side) => `${side}: ${whereText(side)}`).join("; "));
}

cursor.setEnd(along);
cursor.subscribe(follow);
align(true);
slider.addEventListener("input", () => {
  player.pause();
  cursor.set(Number(slider.value), "slider");
});
root.querySelector('[data-side="previous"]').addEventListener("click", () => step(false));
root.querySelector('[data-side="next"]').addEventListener("click", () => step(true));
tracerisk.playButton(root.querySelector('[data-side="play"]'), player, " both");
for (const button of root.querySelectorAll("[data-side-mode]")) {
  button.addEventListener("click", () => align(button.dataset.sideMode === "step"));
}
for (const jump of jumps) {
  jump.addEventListener("click", () => {
    player.pause();
    cursor.set(placeOfDifference(both.differences[Number(jump.dataset.sideAt)]), "mark");
    root.scrollIntoView();
  });
}
// What is printed, or seen before anybody plays it, is the first difference.
cursor.set(both.differences.length ? placeOfDifference(both.differences[0]) : cursor.end, "begin");

async function beginBoth() {
  // The picture at the top of the page comes first.
  await tracerisk.replay.ready;
  const keys = tracerisk.timeKeys({ clock: cursor, player, step });
  let beside = null;
  for (const [side, data] of [["before", "side-before"], ["now", "replay"]]) {
    const { bodies, frames } = tracerisk.data(`${data}-bodies`);
    const stage = root.querySelector(`[data-side-stage="${side}"]`);
    const packed = tracerisk.bytes(`${data}-frames`);
    const choose = (element) =>
      tracerisk.select({ component: runs[side].componentOf.get(element) || null, source: "replay" });
    const options = { bodies, frames, packed, activity: runs[side], choose, clock: clocks[side], keys };
    beside = tracerisk.bothRuns[side] = await tracerisk.replay.create(stage, { ...options, beside });
  }
}

tracerisk.bothRuns = { cursor, clocks, player, align };
tracerisk.bothRuns.ready = beginBoth();
tracerisk.bothRuns.ready.catch((problem) => {
  for (const message of root.querySelectorAll(".replay-message")) {
    message.hidden = false;
    message.textContent = `The runs cannot be shown side by side: ${problem.message}.`;
  }
});
