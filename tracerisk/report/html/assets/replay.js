// The replay: the bodies where the run had them at the cursor's time, coloured by their state.

// A colour of the page as three numbers from 0 to 1.
const tone = (name) =>
  tracerisk.colour(name).match(/[\d.]+/g).slice(0, 3).map((each) => Number(each) / 255);
const mixed = (one, other, part) => one.map((v, i) => v + (other[i] - v) * part);

// What of its states a drive is coloured by.
function stateName(state) {
  if (state & GRASPING) return "grasping";
  if (state & MOVING) return "moving";
  if (state & HOLDING) return "holding";
  return state ? "in-use" : null;
}

// Where the motor of a driven hinge is: a belt about a link that goes along the axis, a drum across
// links that do not.
function collarOf(body, bodies) {
  if (body.joint !== "hinge" || !body.element) return null;
  const around = [];
  let isAlong = false;
  const parent = bodies[body.parent];
  const axis = rotate(body.quat, body.axis);
  for (const [own, place, way] of [[body, [0, 0, 0], body.axis], [parent, body.xyz, axis]]) {
    for (const { kind, size, xyz = [0, 0, 0], quat = identity, contact } of own?.shapes ?? []) {
      if (contact === false) continue;
      const inside = toBody({ xyz, quat }, place);
      const near = nearestInShape({ kind, size }, inside);
      const away = Math.hypot(...near.map((v, i) => v - inside[i]));
      const radius = kind === "box" ? Math.min(...size) : size[0];
      if (away >= radius * 0.5) continue;
      around.push(radius);
      isAlong ||= kind === "sphere" || Math.abs(dot(rotate(quat, [0, 0, 1]), way)) > 0.7;
    }
  }
  if (!around.length) return null;
  const radius = Math.max(...around);
  const [ax, ay, az] = body.axis;
  const tilt = Math.acos(Math.min(Math.max(az, -1), 1));
  const across = Math.hypot(ax, ay);
  const quat =
    across > 1e-9 ? about([-ay / across, ax / across, 0], tilt) : az < 0 ? [0, 1, 0, 0] : identity;
  const size = isAlong ? [radius * 1.12, radius * 0.34] : [radius * 0.75, radius * 1.15];
  return { kind: "cylinder", size, quat };
}

function boundsOf(bodies, meshes, posesAt) {
  const radii = meshes.map((mesh) => {
    let most = 0;
    for (let i = 0; i < mesh.length; i += 6) {
      most = Math.max(most, Math.hypot(mesh[i], mesh[i + 1], mesh[i + 2]));
    }
    return most;
  });
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  let floor = 0;
  posesAt.forEach((posed, turn) => {
    posed.forEach((pose, index) => {
      const { kind } = bodies[index];
      const mesh = meshes[index];
      if (turn === 0 && kind !== "declared") {
        for (let i = 0; i < mesh.length; i += 6) {
          floor = Math.min(floor, toWorld(pose, mesh.subarray(i, i + 3))[2]);
        }
      }
      // A large table must not make the arm small.
      if (kind !== "robot" && kind !== "object" && radii[index] > 0.6) return;
      for (let i = 0; i < 3; i++) {
        const reach = Math.min(radii[index], 0.12);
        low[i] = Math.min(low[i], pose.xyz[i] - reach);
        high[i] = Math.max(high[i], pose.xyz[i] + reach);
      }
    });
  });
  if (!Number.isFinite(low[0])) return { centre: [0, 0, 0.3], radius: 1, floor };
  const centre = low.map((v, i) => (v + high[i]) / 2);
  const radius = Math.max(Math.hypot(...low.map((v, i) => high[i] - v)) / 2, 0.1);
  return { centre, radius, floor: floor - 1e-4 };
}

// Say in place of the picture why there is none; `null` for that there is one.
function tell(text) {
  const stage = document.querySelector(".replay-stage");
  const message = stage.querySelector(".replay-message");
  message.hidden = !text;
  message.textContent = text ?? "";
  stage.classList.toggle("is-off", Boolean(text));
}

async function beginReplay() {
  const stage = document.querySelector(".replay-stage");
  const canvas = stage.querySelector("canvas");
  const labels = stage.querySelector(".replay-labels");
  beginNow();
  const { bodies, frames } = tracerisk.data("replay-bodies");
  if (typeof DecompressionStream === "undefined") {
    tell("This browser is too old for the replay: it cannot unpack its data. The timeline works.");
    return;
  }
  const whole = await unpackFrames(frames, tracerisk.bytes("replay-frames"));
  const values = new Float64Array(frames.quanta.length);
  const posesAtTime = (time) => poses(bodies, valuesAt(frames, whole, time, values));
  let posed = posesAtTime(clock.time);
  let states = new Map();
  let isLabelled = false;
  const isThere = ({ since = 0, until = Infinity }) => clock.time >= since && clock.time < until;
  // A name may be that of several bodies, one after the other.
  const find = (name) => {
    const all = bodies.flatMap((body, i) => (body.name === name ? [i] : []));
    return all.find((i) => isThere(bodies[i])) ?? all[0];
  };
  Object.assign(tracerisk.replay, {
    bodies, frames, poses, bodyPosition: (name) => posed[find(name)].xyz, labels,
    stateOf: (element) => stateName(states.get(element) ?? 0),
  });

  const meshes = bodies.map(bodyMesh);
  const samples = Array.from({ length: 24 }, (_, i) => posesAtTime((clock.end * i) / 23));
  const bounds = boundsOf(bodies, meshes, samples);
  const collars = bodies.map((body) => collarOf(body, bodies));
  const collarMesh = new Map();
  const allMeshes = [...meshes];
  collars.forEach((shape, i) => {
    if (shape) collarMesh.set(i, allMeshes.push(bodyMesh({ shapes: [shape] })) - 1);
  });
  const ball = allMeshes.push(bodyMesh({ shapes: [{ kind: "sphere", size: [1] }] })) - 1;
  const camera = new Camera(bounds);
  tracerisk.replay.camera = camera;
  let drawing;
  try {
    drawing = new Drawing(canvas, allMeshes, bounds);
  } catch (problem) {
    const isNone = problem.message === "no WebGL2";
    tell(
      isNone
        ? "This browser shows no 3-D pictures here (WebGL 2 is missing or switched off). The timeline and the text beside it show the same run."
        : `The 3-D picture cannot be drawn: ${problem.message}`,
    );
    return;
  }

  const componentOf = new Map(
    run.rows.flatMap(({ component, elements }) => elements.map(({ name }) => [name, component])),
  );
  let colours = {};
  const readColours = () => {
    const own = [
      "background", "ground", "robot", "fixture", "object", "declared", "collar", "in-use",
    ];
    const shared = ["moving", "holding", "grasping", "fail"];
    colours = Object.fromEntries([
      ...own.map((name) => [name, tone(`replay-${name}`)]),
      ...shared.map((name) => [name, tone(name)]),
    ]);
  };
  readColours();

  // What several fingers hang on is the housing of their gripper, and shows its state.
  const housing = new Map();
  bodies.forEach(({ joint, element, parent }) => {
    const fingers = bodies.filter((each) => each.joint && each.element === element);
    if (joint && element && fingers.length > 1) housing.set(bodies[parent], element);
  });
  function colourOf(body) {
    const base = colours[body.kind];
    const element = housing.get(body) ?? body.element;
    const state = stateName(states.get(element) ?? 0);
    const { component } = tracerisk.selected;
    const isOther = component !== null && componentOf.get(element) !== component;
    if (!state || isOther) return base;
    // What slides has no collar: it shows its state itself.
    const part = body.joint === "slide" ? 0.85 : housing.has(body) ? 0.6 : 0.32;
    return mixed(base, colours[state], part);
  }
  function shownBodies() {
    const shown = [];
    bodies.forEach((body, i) => {
      if (!meshes[i].length || !isThere(body)) return;
      const model = poseMatrix(posed[i]);
      shown.push({ mesh: i, model, colour: colourOf(body), body: i });
      if (collarMesh.has(i)) {
        const state = stateName(states.get(body.element) ?? 0);
        const { component } = tracerisk.selected;
        const isOther = component !== null && componentOf.get(body.element) !== component;
        const colour = state && !isOther ? colours[state] : colours.collar;
        shown.push({ mesh: collarMesh.get(i), model, colour, body: i });
      }
    });
    return shown;
  }

  function touching() {
    return contactsAt(clock.time).map((contact) => {
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
    placeLabels();
    tracerisk.replay.drawn = (tracerisk.replay.drawn ?? 0) + 1;
  }
  const ask = () => {
    if (isAsked) return;
    isAsked = true;
    requestAnimationFrame(render);
  };

  // Labels that would lie on one another are moved down until they do not.
  function placeLabels() {
    labels.replaceChildren();
    const wanted = [];
    for (const { contact, point } of touches) {
      const kind = contact.expected ? "is-grasping" : "is-fail";
      const text = `${contact.link} \u2013 ${contact.other}, up to ${contact.force.toFixed(1)} N`;
      if (point && (isLabelled || !contact.expected)) wanted.push({ text, point, kind });
    }
    const seen = new Set();
    bodies.forEach(({ element, joint }, i) => {
      const state = states.get(element);
      if (!isLabelled || !element || !joint || !state || seen.has(element)) return;
      seen.add(element);
      const text = `${element}: ${stateWords(state)}`;
      wanted.push({ text, point: posed[i].xyz, kind: `is-${stateName(state)}` });
    });
    const placed = [];
    for (const { text, point, kind } of wanted) {
      const place = view && inClip(view, point);
      if (!place || Math.abs(place[0]) > 1 || Math.abs(place[1]) > 1) continue;
      const x = (place[0] * 0.5 + 0.5) * canvas.clientWidth;
      placed.push({ text, kind, x, y: (0.5 - place[1] * 0.5) * canvas.clientHeight });
    }
    placed.sort((one, other) => one.y - other.y);
    placed.forEach((each, i) => {
      const wide = each.text.length * 6.5;
      for (const above of placed.slice(0, i)) {
        const isBeside = Math.abs(above.x - each.x) > (wide + above.text.length * 6.5) / 2;
        if (!isBeside && each.y - above.y < 20) each.y = above.y + 20;
      }
      const span = document.createElement("span");
      span.className = `replay-label ${each.kind}`;
      span.textContent = each.text;
      span.style.left = `${each.x}px`;
      span.style.top = `${each.y}px`;
      labels.append(span);
    });
  }

  clock.subscribe((time) => {
    posed = posesAtTime(time);
    states = new Map(
      activeAt(time).flatMap(({ elements }) => elements.map(({ name, state }) => [name, state])),
    );
    touches = touching();
    ask();
  });
  document.addEventListener("tracerisk:select", ask);
  document.addEventListener("tracerisk:theme", () => {
    readColours();
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
  stage.querySelector('[data-view="reset"]').addEventListener("click", () => {
    camera.reset();
    ask();
  });
  stage.querySelector('[data-view="labels"]').addEventListener("click", ({ currentTarget }) => {
    isLabelled = !isLabelled;
    currentTarget.setAttribute("aria-pressed", isLabelled);
    ask();
  });
  steer(canvas, camera, ask);
  hover(canvas, labels, (x, y) => {
    const way = camera.ray(x, y, canvas.clientWidth / canvas.clientHeight);
    let [best, found] = [Infinity, null];
    bodies.forEach((body, i) => {
      if (!meshes[i].length || !isThere(body)) return;
      const back = inverse(posed[i].quat);
      const distance = rayHit(meshes[i], toBody(posed[i], camera.eye), rotate(back, way));
      if (distance < best) [best, found] = [distance, body];
    });
    return found;
  }, (body) => {
    const state = states.get(body.element) ?? 0;
    const doing = body.element ? `, ${body.element}: ${state ? stateWords(state) : "idle"}` : "";
    return `${body.name}${doing}`;
  }, (body) => {
    const component = componentOf.get(body?.element) || null;
    tracerisk.select({ component, source: "replay" });
  });
}

tracerisk.replay = { poses, touchPoint };
tracerisk.replay.ready = beginReplay();
tracerisk.replay.ready.catch((problem) => {
  tell(`The replay cannot be shown: ${problem.message}. The timeline works.`);
});
