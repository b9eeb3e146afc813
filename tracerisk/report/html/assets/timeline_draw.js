// Draws the chart as SVG: the band of visits, a line for each row, the ticks of time.

const SVG = "http://www.w3.org/2000/svg";
const ROW = 22;
const LANE = 17;
// A lane for each function distinguishes them without a text; many share one.
const LANES = run.functions.length <= 12 ? run.functions.length : 1;
const BAND = LANES > 1 ? LANES * LANE + 7 : 28;
const AXIS = 22;
const MANY = 2000;

function drawn(name, attributes = {}, parent = null) {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  parent?.append(element);
  return element;
}

// The stretch of time in sight, and how wide it is drawn.
class View {
  from = 0;
  to = run.end || 1;
  width = 1;
  x(time) {
    return ((time - this.from) / (this.to - this.from)) * this.width;
  }
  timeOf(px) {
    return this.from + (px / this.width) * (this.to - this.from);
  }
  has({ start, stop }) {
    return stop >= this.from && start <= this.to;
  }
  get pixel() {
    return (this.to - this.from) / this.width;
  }
}

function drawPatterns(svg) {
  const definitions = drawn("defs", {}, svg);
  const size = { width: 5, height: 5, patternUnits: "userSpaceOnUse" };
  const pattern = drawn(
    "pattern", { id: "timeline-hatch", ...size, patternTransform: "rotate(45)" }, definitions,
  );
  drawn("rect", { width: 1.6, height: 5, class: "timeline-hatch" }, pattern);
}

function drawVisits(svg, view, focused) {
  const band = drawn("g", { class: "timeline-band" }, svg);
  const seen = [...stretches.keys()].filter((index) => view.has(stretches[index]));
  const until = new Map();
  for (const index of seen) {
    const { visit, stop } = stretches[index];
    const lane = run.visits[visit].function;
    // Of very many visits in sight, one a pixel and function is drawn.
    const isHidden = seen.length > MANY && stop - (until.get(lane) ?? -Infinity) < view.pixel;
    if (isHidden && index !== focused) continue;
    until.set(lane, stop);
    drawVisit(band, view, index, index === focused);
  }
}

function drawVisit(band, view, index, isFocused) {
  const { visit, start, stop } = stretches[index];
  const left = Math.max(view.x(start), -2);
  const right = Math.min(view.x(stop), view.width + 2);
  const name = functionOf(visit);
  const lane = run.visits[visit].function;
  const label = `Visit ${visit + 1}: ${name}, from ${secondsText(start)} for ${secondsText(stop - start)}`;
  const group = drawn(
    "g",
    {
      class: `timeline-visit is-shade-${lane % 6}`,
      role: "button",
      tabindex: isFocused ? 0 : -1,
      "aria-label": label,
      "data-stretch": index,
    },
    band,
  );
  const across = Math.max(right - left - 1, 0.6);
  const place = LANES > 1 ? { y: 4 + lane * LANE, height: LANE - 3 } : { y: 3, height: BAND - 7 };
  drawn("rect", { x: left, width: across, rx: Math.min(3, across / 2), ...place }, group);
  if (LANES === 1 && across > 60) {
    const text = drawn("text", { x: Math.max(left, 0) + 5, y: BAND - 10 }, group);
    const room = Math.floor((right - Math.max(left, 0) - 8) / 6.6);
    text.textContent = name.length > room ? `${name.slice(0, Math.max(room - 1, 1))}\u2026` : name;
  }
}

// Distinguished by shape as well: moving is a high bar, holding a low one, grasping a strip on top.
const bars = [
  [MOVING, "moving", 6, 13],
  [HOLDING, "holding", 12, 7],
  [GRASPING, "grasping", 2, 3],
];

// Of very many segments in sight, those that share a pixel are drawn as one.
function drawable(segments, view) {
  const seen = segments.filter((each) => view.has(each));
  if (seen.length <= MANY) return seen;
  const joined = [];
  for (const each of seen) {
    const last = joined.at(-1);
    if (last && each.stop - last.start < view.pixel) {
      last.stop = each.stop;
      last.state |= each.state;
    } else joined.push({ ...each });
  }
  return joined;
}

function drawLine(svg, view, { row, segments, element }, top) {
  const place = { class: `timeline-line${element ? " is-element" : ""}` };
  const name = element?.name ?? row.component;
  const group = drawn("g", { ...place, "data-line": name }, svg);
  drawn("rect", { class: "timeline-lane", x: 0, y: top, width: view.width, height: ROW }, group);
  for (const { start, stop, state } of drawable(segments, view)) {
    const [left, right] = [Math.max(view.x(start), -1), Math.min(view.x(stop), view.width + 1)];
    const across = Math.max(right - left, 0.5);
    const one = drawn("g", { class: "timeline-segment", "data-state": state }, group);
    const known = !(state & SOMEWHEN);
    for (const [bit, word, y, height] of bars) {
      const isHidden = bit === HOLDING && state & MOVING;
      if (state & bit && !isHidden) {
        const kind = `is-${word}${known ? "" : " is-somewhen"}`;
        drawn("rect", { class: kind, x: left, y: top + y, width: across, height }, one);
      }
    }
    if (!(state & (MOVING | HOLDING | GRASPING))) {
      drawn("rect", { class: "is-somewhen", x: left, y: top + 9, width: across, height: 7 }, one);
    }
    if (state & BORDERLINE) {
      const fill = { fill: "url(#timeline-hatch)", x: left, y: top + 6, width: across, height: 13 };
      drawn("rect", { class: "is-borderline", ...fill }, one);
    }
  }
}

// What was found, and what was made to fail: each a mark where it happened, in a line below the rows.
function drawMarks(svg, view, top) {
  if (!run.marks.length) return;
  const group = drawn("g", { class: "timeline-marks-line" }, svg);
  drawn("rect", { class: "timeline-lane", x: 0, y: top, width: view.width, height: ROW }, group);
  run.marks.forEach(({ time, kind, text }, index) => {
    if (time < view.from || time > view.to) return;
    const label = `${kind} at ${secondsText(time)}: ${text}`;
    const one = drawn(
      "g",
      { class: `timeline-mark is-${kind}`, role: "button", tabindex: -1, "aria-label": label, "data-mark": index },
      group,
    );
    const place = view.x(time);
    drawn("line", { x1: place, x2: place, y1: 0, y2: top + 4 }, one);
    const shape = kind === "fault" ? "M-5 -5l10 10M-5 5l10 -10" : "M0 -6l6 6l-6 6l-6 -6z";
    const inSight = Math.min(Math.max(place, 6), view.width - 6);
    drawn("path", { d: shape, transform: `translate(${inSight} ${top + ROW / 2})` }, one);
  });
}

function drawTicks(svg, view, top) {
  const least = view.pixel * 70;
  const power = 10 ** Math.floor(Math.log10(least));
  const step = [1, 2, 5, 10].map((each) => each * power).find((each) => each >= least * (1 - 1e-9));
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  for (let i = Math.ceil(view.from / step); i * step <= view.to + 1e-9; i++) {
    const place = view.x(i * step);
    drawn("line", { class: "timeline-tick", x1: place, x2: place, y1: 0, y2: top + 4 }, svg);
    const anchor = place < 14 ? "start" : place > view.width - 20 ? "end" : "middle";
    const text = drawn(
      "text", { class: "timeline-tick-text", x: place, y: top + 16, "text-anchor": anchor }, svg,
    );
    text.textContent = `${(i * step).toFixed(digits)} s`;
  }
}
