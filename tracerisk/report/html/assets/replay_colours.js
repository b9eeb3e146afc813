// The colours of what is drawn: paint of the maker, states of the drives, shares of the risk.

// A colour of the page, or one that begins with #, as three numbers from 0 to 1.
const tone = (name) => {
  if (name.startsWith("#")) return [1, 3, 5].map((i) => parseInt(name.slice(i, i + 2), 16) / 255);
  return tracerisk.colour(name).match(/[\d.]+/g).slice(0, 3).map((each) => Number(each) / 255);
};
const mixed = (one, other, part) => one.map((v, i) => v + (other[i] - v) * part);

const OWN = ["background", "ground", "robot", "fixture", "object", "declared", "in-use"];
const SHARED = ["moving", "holding", "grasping", "fail", "risk-low", "risk-middle", "risk-high"];

const readColours = () =>
  Object.fromEntries([
    ...OWN.map((name) => [name, tone(`replay-${name}`)]),
    ...SHARED.map((name) => [name, tone(name)]),
  ]);

// What of its states a drive is coloured by.
function stateName(state) {
  if (state & GRASPING) return "grasping";
  if (state & MOVING) return "moving";
  if (state & HOLDING) return "holding";
  return state ? "in-use" : null;
}

// From 0 to 1: the colour of a part of the greatest share.
function riskTone(colours, part) {
  const [low, middle, high] = ["risk-low", "risk-middle", "risk-high"].map((name) => colours[name]);
  return part < 0.5 ? mixed(low, middle, part * 2) : mixed(middle, high, part * 2 - 1);
}

// What several fingers hang on is the housing of their gripper, and shows its state.
function housings(bodies) {
  const found = new Map();
  for (const { joint, element, parent } of bodies) {
    const fingers = bodies.filter((each) => each.joint && each.element === element);
    if (joint && element && fingers.length > 1) found.set(bodies[parent], element);
  }
  return found;
}

// Colour and glow of a piece of a body: `part` of the greatest share, or the state of its drive.
function paintedBy({ colours, body, paint, isJoint, state, part }) {
  let base = paint ? tone(paint) : colours[body.kind];
  if (body.kind !== "robot") return { colour: base, glow: 0 };
  if (part !== null) {
    if (part <= 0) return { colour: base, glow: 0 };
    const colour = riskTone(colours, part);
    return { colour: mixed(base, colour, 0.3 + 0.45 * part), glow: part, glowing: colour };
  }
  if (!state) return { colour: base, glow: 0 };
  // What slides shows its state itself, for it has no joint that could.
  const much = isJoint ? 0.95 : body.joint === "slide" ? 0.85 : 0.34;
  return { colour: mixed(base, colours[state], much), glow: 0 };
}
