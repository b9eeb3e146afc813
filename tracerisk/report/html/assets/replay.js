// The replay: the bodies where the run had them at the cursor's time, coloured by risk or by state.

// The points that the picture is to hold: all that the arm sweeps, what can be moved, and of what
// stands fast only what is small and within reach. `meshes`: those of each body.
function sceneOf(bodies, meshes, posesAt) {
  const boxes = meshes.map((own) => {
    const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
    for (const mesh of own) {
      for (let i = 0; i < mesh.length; i += 6) {
        for (let k = 0; k < 3; k++) {
          if (mesh[i + k] < low[k]) low[k] = mesh[i + k];
          if (mesh[i + k] > high[k]) high[k] = mesh[i + k];
        }
      }
    }
    return { low, high };
  });
  const corners = ({ low, high }) =>
    Array.from({ length: 8 }, (_, k) => low.map((v, i) => ((k >> i) & 1 ? high[i] : v)));
  const size = ({ low, high }) => Math.hypot(...high.map((v, i) => v - low[i]));
  const points = [];
  const fixed = [];
  const work = [0, 0];
  let base = null;
  let floor = Infinity;
  posesAt.forEach((posed, turn) => {
    posed.forEach((pose, index) => {
      const { kind } = bodies[index];
      if (!meshes[index].some((mesh) => mesh.length)) return;
      const placed = () => corners(boxes[index]).map((corner) => toWorld(pose, corner));
      if (turn === 0 && kind !== "declared") {
        for (const corner of placed()) floor = Math.min(floor, corner[2]);
      }
      if (kind === "robot") {
        base ??= pose.xyz;
        for (let i = 0; i < 2; i++) work[i] += pose.xyz[i] - base[i];
        points.push(...placed());
      } else if (kind === "object") points.push(...placed());
      else if (turn === 0 && size(boxes[index]) < 1) fixed.push(placed());
    });
  });
  if (!points.length) points.push(...fixed.splice(0).flat(), [0.3, 0.3, 0], [-0.3, -0.3, 0.6]);
  const spread = () => {
    const low = [0, 1, 2].map((i) => Math.min(...points.map((point) => point[i])));
    const high = [0, 1, 2].map((i) => Math.max(...points.map((point) => point[i])));
    const radius = Math.max(Math.hypot(...high.map((v, i) => v - low[i])) / 2, 0.1);
    return { centre: low.map((v, i) => (v + high[i]) / 2), radius };
  };
  const { centre, radius } = spread();
  for (const corner of fixed) {
    const isNear = corner.every((point) => Math.hypot(...point.map((v, i) => v - centre[i])) < radius);
    if (isNear) points.push(...corner);
  }
  const towards = Math.hypot(...work) > 0.05 ? Math.atan2(work[1], work[0]) : 0;
  floor = Number.isFinite(floor) ? Math.min(floor, 0) - 1e-4 : 0;
  return { ...spread(), points: hullOf(points), floor, towards };
}

// Of many points only those that are extreme in some direction matter to the camera.
const DIRECTIONS = 96;
function hullOf(points) {
  if (points.length < DIRECTIONS) return points;
  const flat = Float64Array.from(points.flat());
  const kept = new Set();
  for (let i = 0; i < DIRECTIONS; i++) {
    // A spiral over the sphere.
    const z = 1 - (2 * i + 1) / DIRECTIONS;
    const across = Math.sqrt(1 - z * z);
    const [x, y] = [Math.cos(i * 2.4) * across, Math.sin(i * 2.4) * across];
    let [most, best] = [-Infinity, 0];
    for (let k = 0; k < flat.length; k += 3) {
      const far = flat[k] * x + flat[k + 1] * y + flat[k + 2] * z;
      if (far > most) [most, best] = [far, k];
    }
    kept.add(best / 3);
  }
  return [...kept].map((index) => points[index]);
}

// Make one arm play in its stage, a `.replay-stage` with its canvas. A page may have several.
//
// `bodies`, `frames`, `packed`: what `replay.py` writes. `activity`: what was in use when, as
// `openRun` returns it. `risk`: what `riskOverTime` returns; without it the colours are those of the
// states. `choose`: called with the element of a click. `clock`: what it follows, that of the page
// if none is given, and `keys`: what moves it. `beside`: a replay whose camera it shares.
// Returns what can be asked of it and `null` where nothing can be drawn.
async function createReplay(stage, {
  bodies, frames, packed, activity = null, risk = null, choose, beside = null,
  clock = tracerisk.clock, keys = timeKey,
}) {
  const canvas = stage.querySelector("canvas");
  const labels = stage.querySelector(".replay-labels");
  const tell = (text) => {
    const message = stage.querySelector(".replay-message");
    message.hidden = !text;
    message.textContent = text ?? "";
    stage.classList.toggle("is-off", Boolean(text));
  };
  if (typeof DecompressionStream === "undefined") {
    tell("This browser is too old for the replay: it cannot unpack its data. The timeline works.");
    return null;
  }
  const whole = await unpackFrames(frames, packed);
  const values = new Float64Array(frames.quanta.length);
  const posesAtTime = (time) => poses(bodies, valuesAt(frames, whole, time, values));
  let posed = posesAtTime(clock.time);
  let states = new Map();
  let isLabelled = false;
  let isRisk = risk !== null;
  // Before anybody has moved the cursor, the arm shows the whole mission.
  let isWhole = true;
  const isThere = ({ since = 0, until = Infinity }) => clock.time >= since && clock.time < until;
  // A name may be that of several bodies, one after the other.
  const find = (name) => {
    const all = bodies.flatMap((body, i) => (body.name === name ? [i] : []));
    return all.find((i) => isThere(bodies[i])) ?? all[0];
  };
  const housing = housings(bodies);
  const elementOf = (body) => housing.get(body) ?? body.element;
  const stateOf = (element) => stateName(states.get(element) ?? 0);
  const riskOf = (element) =>
    risk ? (isWhole ? risk.whole(element) : risk.shareAt(element, clock.time)) : 0;

  const meshes = [];
  const pieces = bodies.map((body) =>
    drawnMeshes(body).map(({ paint, isJoint, mesh }) => ({ paint, isJoint, mesh: meshes.push(mesh) - 1 })),
  );
  const ownMeshes = pieces.map((own) => own.map(({ mesh }) => meshes[mesh]));
  const samples = Array.from({ length: 24 }, (_, i) => posesAtTime((clock.end * i) / 23));
  const scene = sceneOf(bodies, ownMeshes, samples);
  const ball = meshes.push(new Float32Array(tubed([0, 0, 0, 1], false))) - 1;
  const camera = beside?.camera ?? new Camera(scene);
  if (beside) camera.holdToo(scene);
  let drawing;
  try {
    drawing = new Drawing(canvas, meshes, scene);
  } catch (problem) {
    const isNone = problem.message === "no WebGL2";
    tell(
      isNone
        ? "This browser shows no 3-D pictures here (WebGL 2 is missing or switched off). The timeline and the text beside it show the same run."
        : `The 3-D picture cannot be drawn: ${problem.message}`,
    );
    return null;
  }

  let colours = readColours();
  function shownBodies() {
    const shown = [];
    const { component } = tracerisk.selected;
    bodies.forEach((body, i) => {
      if (!isThere(body)) return;
      const model = poseMatrix(posed[i]);
      const element = elementOf(body);
      const isOther = component !== null && activity?.componentOf.get(element) !== component;
      const state = isOther ? null : stateOf(element);
      const part = !isRisk ? null : isOther ? 0 : riskOf(element) / risk.most;
      for (const { mesh, paint, isJoint } of pieces[i]) {
        if (!meshes[mesh].length) continue;
        const look = paintedBy({ colours, body, paint, isJoint, state, part });
        shown.push({ mesh, model, body: i, ...look });
      }
    });
    return shown;
  }

  function touching() {
    return (activity?.contactsAt(clock.time) ?? []).map((contact) => {
      const [one, other] = [find(contact.link), find(contact.other)];
      let point = null;
      if (one !== undefined && other !== undefined) {
        point = touchPoint(bodies[one], posed[one], bodies[other], posed[other]);
      } else if (one !== undefined) point = posed[one].xyz;
      return { contact, point };
    });
  }

  let view = null;
  let isAsked = false;
  let touches = [];
  const replay = {
    bodies, frames, camera, labels, drawn: 0,
    bodyPosition: (name) => posed[find(name)].xyz,
    stateOf, riskOf,
    get colours() {
      return isRisk ? "risk" : "activity";
    },
  };
  function render() {
    isAsked = false;
    const shown = shownBodies();
    for (const { contact, point } of touches) {
      if (!point) continue;
      const away = Math.hypot(...camera.eye.map((v, i) => v - point[i]));
      const size = away * 0.008;
      const colour = contact.expected ? colours.grasping : colours.fail;
      const model = poseMatrix({ xyz: point, quat: identity }, size);
      shown.push({ mesh: ball, model, colour, plain: 1 });
    }
    view = drawing.draw(camera, shown, colours) ?? view;
    placeLabels(labels, wantedLabels(), view, canvas);
    replay.drawn += 1;
  }
  const ask = () => {
    if (isAsked) return;
    isAsked = true;
    requestAnimationFrame(render);
  };
  replay.ask = ask;

  function wantedLabels() {
    const wanted = [];
    for (const { contact, point } of touches) {
      const kind = contact.expected ? "is-grasping" : "is-fail";
      const text = `${contact.link} \u2013 ${contact.other}, up to ${contact.force.toFixed(1)} N`;
      if (point && (isLabelled || !contact.expected)) wanted.push({ text, point, kind });
    }
    const seen = new Set();
    bodies.forEach(({ element, joint }, i) => {
      if (!isLabelled || !element || !joint || seen.has(element)) return;
      const state = states.get(element);
      if (!isRisk && !state) return;
      seen.add(element);
      const doing = isRisk ? percentText(riskOf(element)) : stateWords(state);
      wanted.push({ text: `${element}: ${doing}`, point: posed[i].xyz, kind: isRisk ? "is-risk" : `is-${stateName(state)}` });
    });
    return wanted;
  }

  clock.subscribe((time, source) => {
    if (source !== null) isWhole = false;
    posed = posesAtTime(time);
    states = new Map(
      (activity?.activeAt(time) ?? []).flatMap(({ elements }) =>
        elements.map(({ name, state }) => [name, state])),
    );
    touches = touching();
    showLegend(stage, isRisk ? risk : null, isWhole ? null : time);
    ask();
  });
  document.addEventListener("tracerisk:select", ask);
  document.addEventListener("tracerisk:theme", () => {
    colours = readColours();
    ask();
  });
  new ResizeObserver(ask).observe(canvas);
  canvas.addEventListener("webglcontextlost", (event) => {
    event.preventDefault();
    tell("The graphics card gave up the picture; it comes back as soon as it can.");
  });
  canvas.addEventListener("webglcontextrestored", () => {
    drawing.prepare();
    tell(null);
    ask();
  });
  window.addEventListener("beforeprint", render);
  stage.querySelector('[data-view="reset"]')?.addEventListener("click", () => {
    camera.reset();
    camera.changed();
  });
  stage.querySelector('[data-view="labels"]')?.addEventListener("click", ({ currentTarget }) => {
    isLabelled = !isLabelled;
    currentTarget.setAttribute("aria-pressed", isLabelled);
    ask();
  });
  const modes = [...stage.querySelectorAll("[data-colours]")];
  if (risk && modes.length) modes[0].parentElement.hidden = false;
  for (const button of modes) {
    button.addEventListener("click", () => {
      isRisk = button.dataset.colours === "risk";
      for (const each of modes) each.setAttribute("aria-pressed", each === button);
      showLegend(stage, isRisk ? risk : null, isWhole ? null : clock.time);
      ask();
    });
  }
  camera.watchers.add(ask);
  steer(canvas, camera, keys);
  const under = (x, y) => {
    const way = camera.ray(x, y);
    let [best, found] = [Infinity, null];
    bodies.forEach((body, i) => {
      if (!isThere(body)) return;
      const back = inverse(posed[i].quat);
      const [from, to] = [toBody(posed[i], camera.eye), rotate(back, way)];
      for (const mesh of ownMeshes[i]) {
        const distance = rayHit(mesh, from, to);
        if (distance < best) [best, found] = [distance, body];
      }
    });
    return found;
  };
  hover(canvas, labels, under, (body) => {
    const element = elementOf(body);
    if (!element) return body.name;
    const state = states.get(element) ?? 0;
    const share = risk ? `, ${percentText(risk.whole(element))} of the failure probability` : "";
    return `${body.name}, ${element}: ${state ? stateWords(state) : "idle"}${share}`;
  }, (body) => choose?.(body ? elementOf(body) : null));
  return replay;
}
