// The names beside the chart: the functions, then the components, opened with their elements.

// The lines of the chart below its band: each row, and of those opened each element.
function chartLines(opened) {
  return run.rows.flatMap((row, index) => [
    { row, index, segments: row.segments, element: null },
    ...(opened.has(index) ? row.elements : []).map((element) => ({
      row, index, segments: element.segments, element,
    })),
  ]);
}

function namedLine(kind, ...inside) {
  const line = document.createElement("div");
  line.className = `timeline-name ${kind}`.trim();
  line.append(...inside);
  return line;
}

// A name that chooses what it names in the whole page; `chosen` is `function` or `component`.
function nameButton(chosen, name) {
  const button = document.createElement("button");
  button.type = "button";
  button.className = "timeline-component";
  button.dataset[chosen] = name;
  button.setAttribute("aria-pressed", tracerisk.selected[chosen] === name);
  button.textContent = name;
  button.title = name;
  return button;
}

function functionNames() {
  if (LANES > 1) {
    return run.functions.map((name, i) =>
      namedLine(`is-function${i === LANES - 1 ? " is-last" : ""}`, nameButton("function", name)),
    );
  }
  return [namedLine("is-band", run.functions.length > 1 ? "visits" : (run.functions[0] ?? "visits"))];
}

function elementName({ name }) {
  const line = namedLine("is-element", name);
  line.title = name;
  return line;
}

function rowName(row, isOpen, fold) {
  const line = namedLine("");
  if (row.elements.length > 1) {
    const button = document.createElement("button");
    button.type = "button";
    button.className = "timeline-fold";
    button.setAttribute("aria-expanded", isOpen);
    button.setAttribute("aria-label", row.component ? `Elements of ${row.component}` : `Elements ${NO_COMPONENT}`);
    button.textContent = isOpen ? "\u25be" : "\u25b8";
    button.addEventListener("click", fold);
    line.append(button);
  }
  if (row.component) line.append(nameButton("component", row.component));
  else {
    const label = document.createElement("span");
    label.className = "timeline-component";
    label.textContent = "not counted";
    label.title = `Elements ${NO_COMPONENT}`;
    line.append(label);
  }
  return line;
}

// Show the names; `changed` is called when a component has been opened or closed.
function showNames(names, opened, changed) {
  const kept = document.activeElement?.closest?.(".timeline-name")?.dataset.row;
  names.replaceChildren(...functionNames());
  for (const { row, index, element } of chartLines(opened)) {
    if (element) {
      names.append(elementName(element));
      continue;
    }
    const line = rowName(row, opened.has(index), () => {
      if (!opened.delete(index)) opened.add(index);
      showNames(names, opened, changed);
      changed();
    });
    line.dataset.row = index;
    names.append(line);
  }
  const kinds = new Set(run.marks.map(({ kind }) => `${kind}s`));
  if (kinds.size) names.append(namedLine("is-marks", [...kinds].sort().join(", ")));
  if (kept !== undefined) names.querySelector(`[data-row="${kept}"] .timeline-fold`)?.focus();
}
