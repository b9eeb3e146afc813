// The camera: it looks at `target` from `distance` [m]; yaw and pitch in radians, z points up.

const OPEN = Math.tan(0.3);
const FILLED = 0.92; // of the frame, by what it is to hold

class Camera {
  // `home`: the points that the picture is to hold, the direction of the work, a radius.
  constructor(home) {
    this.home = home;
    this.aspect = 4 / 3;
    this.covered = 0; // part of the height that buttons cover
    this.watchers = new Set(); // called when somebody has moved it
    this.reset();
  }
  reset() {
    this.yaw = this.home.towards - 0.95;
    this.pitch = 0.34;
    this.fit();
  }
  // Hold what another picture shows as well, which is to be seen from the same place.
  holdToo({ points, radius }) {
    this.home = {
      ...this.home,
      points: hullOf([...this.home.points, ...points]),
      radius: Math.max(this.home.radius, radius),
    };
    this.reset();
    this.changed();
  }
  changed() {
    for (const watcher of this.watchers) watcher();
  }
  // Go as near as all points allow, and put them in the middle of what the buttons leave free.
  fit() {
    const { points, radius } = this.home;
    const { back, right, up } = this.axes();
    const [sideways, upwards] = this.opening();
    // A point is in sight where x / (eye - depth) is within the opening: four planes.
    const side = 1 / (sideways * FILLED);
    const top = 1 / (upwards * FILLED * (1 - 2 * this.covered));
    const foot = 1 / (upwards * FILLED);
    const edge = { left: -Infinity, right: -Infinity, low: -Infinity, high: -Infinity };
    for (const point of points) {
      const [x, y, deep] = [dot(point, right), dot(point, up), dot(point, back)];
      edge.right = Math.max(edge.right, x * side + deep);
      edge.left = Math.max(edge.left, -x * side + deep);
      edge.high = Math.max(edge.high, y * top + deep);
      edge.low = Math.max(edge.low, -y * foot + deep);
    }
    const x = (edge.right - edge.left) / (2 * side);
    let y = (edge.high - edge.low) / (top + foot);
    const eye = Math.max((edge.right + edge.left) / 2, edge.high - y * top);
    // Where the sides decide, what is free above and below is shared.
    y = (edge.high - eye) / top / 2 + (eye - edge.low) / foot / 2;
    const middle = points.reduce((sum, point) => sum + dot(point, back), 0) / points.length;
    this.distance = Math.max(eye - middle, radius * 0.5);
    this.target = right.map((v, i) => v * x + up[i] * y + back[i] * middle);
    this.isHome = true;
  }
  orbit(dx, dy) {
    this.isHome = false;
    this.yaw -= dx;
    this.pitch = Math.min(Math.max(this.pitch + dy, -0.2), 1.55);
  }
  zoom(factor) {
    this.isHome = false;
    const { radius } = this.home;
    this.distance = Math.min(Math.max(this.distance * factor, radius * 0.2), radius * 12);
  }
  pan(dx, dy) {
    this.isHome = false;
    const { right, up } = this.axes();
    const scale = this.distance * 0.5;
    this.target = this.target.map((v, i) => v - (right[i] * dx - up[i] * dy) * scale);
  }
  axes() {
    const [cy, sy, cp, sp] = [this.yaw, this.pitch].flatMap((a) => [Math.cos(a), Math.sin(a)]);
    const back = [cp * cy, cp * sy, sp];
    return { back, right: [-sy, cy, 0], up: [-sp * cy, -sp * sy, cp] };
  }
  get eye() {
    const { back } = this.axes();
    return this.target.map((v, i) => v + back[i] * this.distance);
  }
  // How far the picture reaches to its sides, and up and down, at a distance of 1.
  opening() {
    return this.aspect < 1 ? [OPEN, OPEN / this.aspect] : [OPEN * this.aspect, OPEN];
  }
  // World to clip space, column after column.
  matrix(aspect, covered = 0) {
    if (Math.abs(aspect - this.aspect) > 1e-6 || covered !== this.covered) {
      Object.assign(this, { aspect, covered });
      // As long as nobody has moved it, the view fits its frame.
      if (this.isHome) this.fit();
    }
    const { back, right, up } = this.axes();
    const near = this.distance * 0.02;
    const far = this.distance + this.home.radius * 30;
    const [sideways, upwards] = this.opening();
    return product(
      [1 / sideways, 0, 0, 0, 0, 1 / upwards, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0,
        (2 * far * near) / (near - far), 0],
      looking(this.eye, right, up, back),
    );
  }
  // The direction in which a point of the picture lies; x and y from -1 to 1.
  ray(x, y) {
    const { back, right, up } = this.axes();
    const [sideways, upwards] = this.opening();
    return back.map((v, i) => right[i] * x * sideways + up[i] * y * upwards - v);
  }
}

function looking(eye, right, up, back) {
  return [
    right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0,
    -dot(right, eye), -dot(up, eye), -dot(back, eye), 1,
  ];
}

function product(a, b) {
  const out = new Array(16).fill(0);
  for (let column = 0; column < 4; column++) {
    for (let row = 0; row < 4; row++) {
      for (let k = 0; k < 4; k++) out[column * 4 + row] += a[k * 4 + row] * b[column * 4 + k];
    }
  }
  return out;
}

function poseMatrix({ xyz, quat }, scale = 1) {
  const [x, y, z] = [[scale, 0, 0], [0, scale, 0], [0, 0, scale]].map((v) => rotate(quat, v));
  return [...x, 0, ...y, 0, ...z, 0, ...xyz, 1];
}

function inClip(matrix, p) {
  const [x, y, , w] = [0, 1, 2, 3].map(
    (row) => matrix[row] * p[0] + matrix[4 + row] * p[1] + matrix[8 + row] * p[2] + matrix[12 + row],
  );
  return w > 0 ? [x / w, y / w] : null;
}
