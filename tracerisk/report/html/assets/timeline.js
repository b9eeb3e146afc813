// The chart: a band of visits above, below it a row a component, opened a row an element.

function beginChart() {
  const chart = document.querySelector(".timeline-chart");
  const plot = chart.querySelector(".timeline-plot");
  // Browsers would stop at what listens to keys; the visits within are the stop.
  const labels = { class: "timeline-svg", role: "group", "aria-label": "Timeline", tabindex: -1 };
  const svg = drawn("svg", labels, plot);
  const opened = new Set();
  const view = new View();
  let focused = 0;

  function draw(across = plot.clientWidth) {
    view.width = Math.max(across, 50);
    const lines = chartLines(opened);
    const rows = BAND + lines.length * ROW;
    const bottom = rows + (run.marks.length ? ROW : 0);
    const hadFocus = svg.contains(document.activeElement);
    svg.replaceChildren();
    svg.setAttribute("width", view.width);
    svg.setAttribute("height", bottom + AXIS);
    drawPatterns(svg);
    drawVisits(svg, view, focused);
    // One visit in sight can be reached by the Tab key.
    const reached = svg.querySelector('[tabindex="0"]') ?? svg.querySelector(".timeline-visit");
    reached?.setAttribute("tabindex", 0);
    lines.forEach((line, index) => drawLine(svg, view, line, BAND + index * ROW));
    drawMarks(svg, view, rows);
    drawTicks(svg, view, bottom);
    drawn("line", { class: "timeline-cursor", y1: 0, y2: bottom }, svg);
    drawn("path", { class: "timeline-grip", d: "M-6 0h12l-6 8z" }, svg);
    moveCursor(clock.time);
    markChosen(tracerisk.selected.function, tracerisk.selected.component);
    if (hadFocus) svg.querySelector('[tabindex="0"]')?.focus();
  }

  function moveCursor(time) {
    const place = view.x(time);
    const cursor = svg.querySelector(".timeline-cursor");
    cursor.setAttribute("x1", place);
    cursor.setAttribute("x2", place);
    svg.querySelector(".timeline-grip").setAttribute("transform", `translate(${place} 0)`);
    for (const each of svg.querySelectorAll(".timeline-visit.is-now")) each.classList.remove("is-now");
    const now = stretches.indexOf(at(stretches, time));
    svg.querySelector(`[data-stretch="${now}"]`)?.classList.add("is-now");
  }

  const timeUnder = (event) => view.timeOf(event.clientX - svg.getBoundingClientRect().left);

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
    // What is too short to be drawn among many is shown alone.
    if (!svg.querySelector(`[data-stretch="${focused}"]`)) zoomTo(stretches[focused]);
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
    const time = timeUnder(event);
    const y = event.clientY - svg.getBoundingClientRect().top;
    if (time < view.from || time > view.to) return null;
    if (y < BAND) return visitTip(at(stretches, time));
    const line = chartLines(opened)[Math.floor((y - BAND) / ROW)];
    return line ? lineTip(line, time) : marksTip(time, 6 * view.pixel);
  }

  svg.addEventListener("pointermove", (event) => {
    if (event.buttons & 1) clock.set(timeUnder(event), "timeline");
    showTip(tipText(event), event.clientX, event.clientY);
  });
  svg.addEventListener("pointerleave", () => showTip(null));
  svg.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    player.pause();
    const visit = event.target.closest(".timeline-visit");
    const mark = event.target.closest(".timeline-mark");
    if (mark) clock.set(run.marks[Number(mark.dataset.mark)].time, "timeline");
    else if (visit) goToVisit(Number(visit.dataset.stretch));
    else {
      clock.set(timeUnder(event), "timeline");
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
      const by = (event.deltaY || event.deltaX) * view.pixel;
      return show(view.from + by, view.to + by);
    }
    const middle = timeUnder(event);
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
  showNames(chart.querySelector(".timeline-names"), opened, () => draw());
  draw();
  new ResizeObserver(() => {
    if (plot.clientWidth !== view.width) draw();
  }).observe(plot);
  // A sheet of paper is narrower than most windows.
  addEventListener("beforeprint", () => draw(Math.min(plot.clientWidth, 530)));
  addEventListener("afterprint", () => draw());
  return { show, view };
}
tracerisk.timeline = beginChart();
