// The chart: a band of visits above, below it a row a component, opened a row an element.

const SVG = "http://www.w3.org/2000/svg";
const ROW = 22;
const LANE = 17;
// A lane for each function tells them apart without a text; many share one.
const LANES = run.functions.length <= 12 ? run.functions.length : 1;
const BAND = LANES > 1 ? LANES * LANE + 7 : 28;
const AXIS = 22;

function drawn(name, attributes = {}, parent = null) {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  parent?.append(element);
  return element;
}

function beginChart() {
  const chart = document.querySelector(".timeline-chart");
  const names = chart.querySelector(".timeline-names");
  const plot = chart.querySelector(".timeline-plot");
  const tip = document.querySelector(".timeline-tip");
  const svg = drawn("svg", { class: "timeline-svg", role: "group", "aria-label": "Timeline" }, plot);
  const opened = new Set();
  const view = { from: 0, to: run.end || 1 };
  let width = 1;
  let focused = 0;

  const x = (time) => ((time - view.from) / (view.to - view.from)) * width;
  const timeOf = (px) => view.from + (px / width) * (view.to - view.from);

  function lines() {
    return run.rows.flatMap((row, index) => [
      { row, index, segments: row.segments, element: null },
      ...(opened.has(index) ? row.elements : []).map((element) => ({
        row, index, segments: element.segments, element,
      })),
    ]);
  }

  function nameRows() {
    const kept = document.activeElement?.closest?.(".timeline-name")?.dataset.row;
    names.replaceChildren();
    nameLanes();
    for (const { row, index, element } of lines()) {
      const line = document.createElement("div");
      line.className = `timeline-name${element ? " is-element" : ""}`;
      if (element) {
        line.textContent = element.name;
        line.title = element.name;
        names.append(line);
        continue;
      }
      line.dataset.row = index;
      const name = row.component || "no component";
      const isMany = row.elements.length > 1;
      if (isMany) {
        const fold = document.createElement("button");
        fold.type = "button";
        fold.className = "timeline-fold";
        fold.setAttribute("aria-expanded", opened.has(index));
        fold.setAttribute("aria-label", `Elements of ${name}`);
        fold.textContent = opened.has(index) ? "\u25be" : "\u25b8";
        fold.addEventListener("click", () => {
          if (!opened.delete(index)) opened.add(index);
          nameRows();
          draw();
        });
        line.append(fold);
      }
      const label = document.createElement(row.component ? "button" : "span");
      label.className = "timeline-component";
      if (row.component) {
        label.type = "button";
        label.dataset.component = row.component;
        label.setAttribute("aria-pressed", tracerisk.selected.component === row.component);
      }
      label.textContent = name;
      label.title = name;
      line.append(label);
      names.append(line);
    }
    if (kept !== undefined) names.querySelector(`[data-row="${kept}"] .timeline-fold`)?.focus();
  }

  function nameLanes() {
    if (LANES === 1) {
      const head = document.createElement("div");
      head.className = "timeline-name is-band";
      head.textContent = run.functions.length > 1 ? "visits" : (run.functions[0] ?? "visits");
      names.append(head);
      return;
    }
    run.functions.forEach((name, i) => {
      const line = document.createElement("div");
      line.className = `timeline-name is-function${i === LANES - 1 ? " is-last" : ""}`;
      const button = document.createElement("button");
      button.type = "button";
      button.className = "timeline-component";
      button.dataset.function = name;
      button.setAttribute("aria-pressed", tracerisk.selected.function === name);
      button.textContent = name;
      button.title = name;
      line.append(button);
      names.append(line);
    });
  }

  function draw(across = plot.clientWidth) {
    width = Math.max(across, 50);
    const all = lines();
    const height = BAND + all.length * ROW + AXIS;
    const hadFocus = svg.contains(document.activeElement);
    svg.replaceChildren();
    svg.setAttribute("width", width);
    svg.setAttribute("height", height);
    patterns();
    const band = drawn("g", { class: "timeline-band" }, svg);
    stretches.forEach((stretch, index) => drawVisit(band, stretch, index));
    all.forEach((line, index) => drawLine(line, BAND + index * ROW));
    ticks(BAND + all.length * ROW);
    drawn("line", { class: "timeline-cursor", y1: 0, y2: height - AXIS }, svg);
    drawn("path", { class: "timeline-grip", d: "M-6 0h12l-6 8z" }, svg);
    moveCursor(clock.time);
    markChosen(tracerisk.selected.function, tracerisk.selected.component);
    if (hadFocus) svg.querySelector('[tabindex="0"]')?.focus();
  }

  function patterns() {
    const definitions = drawn("defs", {}, svg);
    const pattern = drawn(
      "pattern",
      {
        id: "timeline-hatch", width: 5, height: 5,
        patternUnits: "userSpaceOnUse", patternTransform: "rotate(45)",
      },
      definitions,
    );
    drawn("rect", { width: 1.6, height: 5, class: "timeline-hatch" }, pattern);
  }

  function drawVisit(band, { visit, start, stop }, index) {
    const left = Math.max(x(start), -2);
    const right = Math.min(x(stop), width + 2);
    if (right < 0 || left > width) return;
    const name = functionOf(visit);
    const group = drawn(
      "g",
      {
        class: `timeline-visit is-shade-${run.visits[visit].function % 6}`,
        role: "button",
        tabindex: index === focused ? 0 : -1,
        "aria-label": `Visit ${visit + 1}: ${name}, from ${secondsText(start)} for ${secondsText(stop - start)}`,
        "data-stretch": index,
      },
      band,
    );
    const across = Math.max(right - left - 1, 0.6);
    const lane = LANES > 1 ? run.visits[visit].function : 0;
    const place = LANES > 1 ? { y: 4 + lane * LANE, height: LANE - 3 } : { y: 3, height: BAND - 7 };
    drawn("rect", { x: left, width: across, rx: Math.min(3, across / 2), ...place }, group);
    if (LANES === 1 && across > 60) {
      const text = drawn("text", { x: Math.max(left, 0) + 5, y: BAND - 10 }, group);
      const room = Math.floor((right - Math.max(left, 0) - 8) / 6.6);
      text.textContent = name.length > room ? `${name.slice(0, Math.max(room - 1, 1))}\u2026` : name;
    }
  }

  // Told apart by shape as well: moving is a high bar, holding a low one, grasping a strip on top.
  const bars = [
    [MOVING, "moving", 6, 13],
    [HOLDING, "holding", 12, 7],
    [GRASPING, "grasping", 2, 3],
  ];

  // Of very many segments in sight, those that share a pixel are drawn as one.
  function drawable(segments) {
    const seen = segments.filter(({ start, stop }) => stop >= view.from && start <= view.to);
    if (seen.length <= 2000) return seen;
    const pixel = (view.to - view.from) / width;
    const joined = [];
    for (const each of seen) {
      const last = joined.at(-1);
      if (last && each.stop - last.start < pixel) {
        last.stop = each.stop;
        last.state |= each.state;
      } else joined.push({ ...each });
    }
    return joined;
  }

  function drawLine({ row, segments, element }, top) {
    const place = { class: `timeline-line${element ? " is-element" : ""}` };
    const name = element?.name ?? row.component;
    const group = drawn("g", { ...place, "data-line": name }, svg);
    drawn("rect", { class: "timeline-lane", x: 0, y: top, width, height: ROW }, group);
    for (const { start, stop, state } of drawable(segments)) {
      const [left, right] = [Math.max(x(start), -1), Math.min(x(stop), width + 1)];
      if (right < 0 || left > width) continue;
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

  function ticks(top) {
    const span = view.to - view.from;
    const least = (span * 70) / width;
    const power = 10 ** Math.floor(Math.log10(least));
    const step = [1, 2, 5, 10].map((each) => each * power).find((each) => each >= least);
    const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    for (let i = Math.ceil(view.from / step); i * step <= view.to + 1e-9; i++) {
      const place = x(i * step);
      drawn("line", { class: "timeline-tick", x1: place, x2: place, y1: 0, y2: top + 4 }, svg);
      const anchor = place < 14 ? "start" : place > width - 20 ? "end" : "middle";
      const text = drawn(
        "text", { class: "timeline-tick-text", x: place, y: top + 16, "text-anchor": anchor }, svg,
      );
      text.textContent = `${(i * step).toFixed(digits)} s`;
    }
  }

  function moveCursor(time) {
    const place = x(time);
    const cursor = svg.querySelector(".timeline-cursor");
    cursor.setAttribute("x1", place);
    cursor.setAttribute("x2", place);
    svg.querySelector(".timeline-grip").setAttribute("transform", `translate(${place} 0)`);
    const now = at(stretches, time);
    for (const each of svg.querySelectorAll(".timeline-visit.is-now")) each.classList.remove("is-now");
    if (now) {
      svg.querySelector(`[data-stretch="${stretches.indexOf(now)}"]`)?.classList.add("is-now");
    }
  }

  function show(from, to) {
    const span = Math.min(Math.max(to - from, Math.min(0.1, run.end || 0.1)), run.end || 1);
    view.from = Math.min(Math.max(from, 0), Math.max((run.end || 1) - span, 0));
    view.to = view.from + span;
    draw();
  }

  function focusVisit(index) {
    focused = Math.min(Math.max(index, 0), stretches.length - 1);
    const { start, stop } = stretches[focused];
    if (start < view.from || stop > view.to) {
      const span = Math.max(view.to - view.from, stop - start);
      show(start - span / 4, start - span / 4 + span);
    }
    for (const each of svg.querySelectorAll(".timeline-visit")) {
      each.setAttribute("tabindex", Number(each.dataset.stretch) === focused ? 0 : -1);
    }
    svg.querySelector(`[data-stretch="${focused}"]`)?.focus();
  }

  function goToVisit(index) {
    const { visit, start } = stretches[index];
    clock.set(start, "timeline");
    tracerisk.select({ function: functionOf(visit), source: "timeline" });
  }

  function tipText(event) {
    const box = svg.getBoundingClientRect();
    const time = timeOf(event.clientX - box.left);
    const y = event.clientY - box.top;
    if (time < view.from || time > view.to) return null;
    if (y < BAND) return visitTip(at(stretches, time));
    const line = lines()[Math.floor((y - BAND) / ROW)];
    if (!line) return null;
    const name = line.element?.name ?? (line.row.component || "no component");
    if (line.row.always && !line.element) return `${name}: always in use`;
    const segment = at(line.segments, time);
    if (!segment) return `${name}: idle at ${secondsText(time)}`;
    const { start, stop, state } = segment;
    return `${name}: ${stateWords(state)}, ${secondsText(start)} to ${secondsText(stop)}`;
  }

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

  function showTip(text, left, top) {
    tip.hidden = !text;
    if (!text) return;
    tip.textContent = text;
    const room = document.documentElement.clientWidth - tip.offsetWidth - 8;
    tip.style.left = `${Math.max(Math.min(left + 12, room), 4)}px`;
    tip.style.top = `${top + 18}px`;
  }

  svg.addEventListener("pointermove", (event) => {
    if (event.buttons & 1) clock.set(timeOf(event.clientX - svg.getBoundingClientRect().left), "timeline");
    showTip(tipText(event), event.clientX, event.clientY);
  });
  svg.addEventListener("pointerleave", () => showTip(null));
  svg.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    player.pause();
    const visit = event.target.closest(".timeline-visit");
    if (visit) goToVisit(Number(visit.dataset.stretch));
    else {
      clock.set(timeOf(event.clientX - svg.getBoundingClientRect().left), "timeline");
      svg.setPointerCapture(event.pointerId);
    }
  });
  svg.addEventListener("dblclick", (event) => {
    const visit = event.target.closest(".timeline-visit");
    if (visit) zoomTo(stretches[Number(visit.dataset.stretch)]);
  });
  svg.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && !event.shiftKey) return;
    event.preventDefault();
    const span = view.to - view.from;
    if (event.shiftKey) {
      const by = ((event.deltaY || event.deltaX) / width) * span;
      return show(view.from + by, view.to + by);
    }
    const middle = timeOf(event.clientX - svg.getBoundingClientRect().left);
    const factor = Math.exp(event.deltaY * 0.002);
    show(middle - (middle - view.from) * factor, middle + (view.to - middle) * factor);
  }, { passive: false });
  svg.addEventListener("focusin", (event) => {
    const visit = event.target.closest(".timeline-visit");
    if (!visit) return;
    const box = visit.getBoundingClientRect();
    showTip(visitTip(stretches[Number(visit.dataset.stretch)]), box.left, box.top + 12);
  });
  svg.addEventListener("focusout", () => showTip(null));
  svg.addEventListener("keydown", (event) => {
    const visit = event.target.closest(".timeline-visit");
    const index = visit ? Number(visit.dataset.stretch) : focused;
    if (event.key === "ArrowRight") focusVisit(index + 1);
    else if (event.key === "ArrowLeft") focusVisit(index - 1);
    else if (event.key === "Enter") goToVisit(index);
    else if (event.key === "z") zoomTo(stretches[index]);
    else {
      timeKey(event);
      return;
    }
    event.preventDefault();
  });

  function zoomTo(stretch) {
    if (!stretch) return;
    const margin = (stretch.stop - stretch.start) * 0.08;
    show(stretch.start - margin, stretch.stop + margin);
  }
  document.querySelector('[data-time="visit"]').addEventListener("click", () => {
    zoomTo(at(stretches, clock.time));
  });
  document.querySelector('[data-time="whole"]').addEventListener("click", () => show(0, run.end));
  document.addEventListener("tracerisk:select", (event) => {
    const { function: name, component } = event.detail;
    markChosen(name, component);
  });
  function markChosen(name, component) {
    chart.classList.toggle("has-function", run.functions.includes(name));
    chart.classList.toggle("has-component", component !== null);
    const chosen = run.functions.indexOf(name);
    for (const each of svg.querySelectorAll(".timeline-visit")) {
      const { visit } = stretches[Number(each.dataset.stretch)];
      each.classList.toggle("is-chosen", run.visits[visit].function === chosen);
    }
    for (const each of svg.querySelectorAll(".timeline-line")) {
      const row = run.rows.find(({ elements, component: own }) =>
        own === each.dataset.line || elements.some(({ name: element }) => element === each.dataset.line));
      each.classList.toggle("is-chosen", row?.component === component);
    }
  }
  clock.subscribe((time, source) => {
    const span = view.to - view.from;
    // What plays, or is stepped to, stays in sight.
    if (source !== "timeline" && svg.firstChild && (time < view.from || time > view.to)) {
      show(time - span * 0.1, time + span * 0.9);
    } else if (svg.firstChild) moveCursor(time);
  });
  nameRows();
  draw();
  new ResizeObserver(() => {
    if (plot.clientWidth !== width) draw();
  }).observe(plot);
  // A sheet of paper is narrower than most windows.
  addEventListener("beforeprint", () => draw(Math.min(plot.clientWidth, 530)));
  addEventListener("afterprint", () => draw());
  return { show, view };
}
tracerisk.timeline = beginChart();
