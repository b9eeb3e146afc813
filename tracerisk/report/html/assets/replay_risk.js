// How the mission's failure probability falls on elements, and how it fills up over the run.

// `shares`: rows of function, component, element (null: seen nowhere on the arm) and part.
// Within a function a part is spread over the time for which its element is in use.
function riskOverTime(shares) {
  const stretchesOf = new Map();
  for (const { visit, start, stop } of stretches) {
    const name = functionOf(visit);
    if (!stretchesOf.has(name)) stretchesOf.set(name, []);
    stretchesOf.get(name).push({ start, stop });
  }
  const segmentsOf = new Map(
    run.rows.flatMap(({ elements }) => elements.map(({ name, segments }) => [name, segments])),
  );
  const elementsOf = new Map(
    run.rows.map(({ component, elements }) => [component, elements.map(({ name }) => name)]),
  );
  const pieces = new Map(); // by element, or by component where nothing of it is on the arm
  const add = (name, own, share) => {
    const total = own.reduce((sum, { start, stop }) => sum + stop - start, 0);
    if (!total) return;
    if (!pieces.has(name)) pieces.set(name, []);
    for (const { start, stop } of own) {
      pieces.get(name).push({ start, stop, share: (share * (stop - start)) / total });
    }
  };
  const elsewhere = new Map();
  const everywhere = [{ start: 0, stop: Math.max(run.end, 1e-3) }];
  for (const [name, component, element, share] of shares) {
    const current = stretchesOf.get(name) ?? everywhere;
    const elements = element === null ? elementsOf.get(component) ?? [] : [element];
    for (const each of elements) {
      const used = overlaps(segmentsOf.get(each) ?? [], current);
      add(each, used.length ? used : current, share / elements.length);
    }
    if (elements.length) continue;
    add(component, current, share);
    elsewhere.set(component, (elsewhere.get(component) ?? 0) + share);
  }
  for (const own of pieces.values()) {
    own.sort((one, other) => one.start - other.start);
    let before = 0;
    for (const piece of own) {
      piece.before = before;
      before += piece.share;
    }
  }
  const shareAt = (name, time) => {
    const own = pieces.get(name);
    if (!own) return 0;
    let [low, high] = [0, own.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (own[middle].start <= time) low = middle + 1;
      else high = middle;
    }
    if (!low) return 0;
    const { start, stop, share, before } = own[low - 1];
    return before + share * Math.min((time - start) / (stop - start || 1), 1);
  };
  const whole = (name) => shareAt(name, Infinity);
  const onArm = [...pieces.keys()].filter((name) => !elsewhere.has(name));
  return {
    shareAt, whole, elsewhere,
    most: Math.max(...onArm.map(whole), 1e-12),
    soFar: (time) => [...pieces.keys()].reduce((sum, name) => sum + shareAt(name, time), 0),
  };
}

// What two lists of stretches, each in order, have in common.
function overlaps(one, other) {
  const found = [];
  for (let i = 0, j = 0; i < one.length && j < other.length;) {
    const start = Math.max(one[i].start, other[j].start);
    const stop = Math.min(one[i].stop, other[j].stop);
    if (stop > start) found.push({ start, stop });
    if (one[i].stop < other[j].stop) i++;
    else j++;
  }
  return found;
}

function percentText(share) {
  if (share > 0 && share < 1e-4) return "<\u00a00.01\u00a0%";
  return `${Number((100 * share).toPrecision(3))}\u00a0%`;
}
