// Where bodies are: packed frames unpacked, and the tree of bodies posed by them.
// Quaternions are [w, x, y, z]; a pose is [x, y, z, w, x, y, z].

function rotate(q, v, out = [0, 0, 0]) {
  const [w, x, y, z] = q;
  const tx = 2 * (y * v[2] - z * v[1]);
  const ty = 2 * (z * v[0] - x * v[2]);
  const tz = 2 * (x * v[1] - y * v[0]);
  out[0] = v[0] + w * tx + (y * tz - z * ty);
  out[1] = v[1] + w * ty + (z * tx - x * tz);
  out[2] = v[2] + w * tz + (x * ty - y * tx);
  return out;
}

function multiply(a, b) {
  return [
    a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
    a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
    a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
    a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
  ];
}

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0],
];
const inverse = (q) => [q[0], -q[1], -q[2], -q[3]];
const about = (axis, angle) => {
  const s = Math.sin(angle / 2);
  return [Math.cos(angle / 2), s * axis[0], s * axis[1], s * axis[2]];
};
const toWorld = (pose, point) => {
  const turned = rotate(pose.quat, point);
  return [turned[0] + pose.xyz[0], turned[1] + pose.xyz[1], turned[2] + pose.xyz[2]];
};
const toBody = (pose, point) =>
  rotate(inverse(pose.quat), [
    point[0] - pose.xyz[0],
    point[1] - pose.xyz[1],
    point[2] - pose.xyz[2],
  ]);

// The poses of all bodies for the values of the columns: those of a body follow its parent's.
function poses(bodies, values) {
  const found = [];
  for (const body of bodies) {
    let { xyz, quat } = body;
    if (body.joint === "free") {
      xyz = Array.from(values.slice(body.column, body.column + 3));
      quat = Array.from(values.slice(body.column + 3, body.column + 7));
      const length = Math.hypot(...quat) || 1;
      quat = quat.map((each) => each / length);
    } else if (body.parent >= 0) {
      const parent = found[body.parent];
      xyz = toWorld(parent, xyz);
      quat = multiply(parent.quat, quat);
    }
    if (body.joint === "hinge") {
      quat = multiply(quat, about(body.axis, values[body.column]));
    } else if (body.joint === "slide") {
      const way = rotate(quat, body.axis);
      const value = values[body.column];
      xyz = [xyz[0] + value * way[0], xyz[1] + value * way[1], xyz[2] + value * way[2]];
    }
    found.push({ xyz, quat });
  }
  return found;
}

async function inflated(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Frames as whole quanta, column after column: what `replay_frames.py` packed.
async function unpackFrames(frames, packed) {
  const { count, quanta, first } = frames;
  const columns = quanta.length;
  const whole = new Int32Array(count * columns);
  if (!count) return whole;
  const planes = count > 1 ? await inflated(packed) : new Uint8Array(0);
  const half = columns * (count - 1);
  if (planes.length !== 2 * half) throw new Error("the frames of the replay are incomplete");
  for (let column = 0, from = 0; column < columns; column++) {
    let value = first[column];
    whole[column * count] = value;
    for (let frame = 1; frame < count; frame++, from++) {
      value += ((planes[from] | (planes[half + from] << 8)) << 16) >> 16;
      whole[column * count + frame] = value;
    }
  }
  return whole;
}

// The values of the columns at a time [s], between two frames in proportion.
function valuesAt(frames, whole, time, out) {
  const { count, every, quanta } = frames;
  const at = Math.min(Math.max(time / every, 0), count - 1);
  const frame = Math.min(Math.floor(at + 1e-9), Math.max(count - 2, 0));
  const part = count > 1 ? at - frame : 0;
  for (let column = 0; column < quanta.length; column++) {
    const from = whole[column * count + frame];
    const to = count > 1 ? whole[column * count + frame + 1] : from;
    out[column] = (from + (to - from) * part) * quanta[column];
  }
  return out;
}
