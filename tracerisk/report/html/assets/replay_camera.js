// The camera: it looks at `target` from `distance` [m]; yaw and pitch in radians, z points up.

class Camera {
  constructor(bounds) {
    this.home = bounds;
    this.reset();
  }
  reset() {
    this.target = [...this.home.centre];
    this.distance = this.home.radius * 2.3;
    this.yaw = -0.9;
    this.pitch = 0.42;
  }
  orbit(dx, dy) {
    this.yaw -= dx;
    this.pitch = Math.min(Math.max(this.pitch + dy, -0.2), 1.55);
  }
  zoom(factor) {
    const { radius } = this.home;
    this.distance = Math.min(Math.max(this.distance * factor, radius * 0.2), radius * 12);
  }
  pan(dx, dy) {
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
  // World to clip space, column after column.
  matrix(aspect) {
    const { back, right, up } = this.axes();
    const focal = 1 / Math.tan(0.36);
    const near = this.distance * 0.02;
    const far = this.distance + this.home.radius * 30;
    const across = aspect < 1 ? focal : focal / aspect;
    const upward = aspect < 1 ? focal * aspect : focal;
    return product(
      [across, 0, 0, 0, 0, upward, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0,
        (2 * far * near) / (near - far), 0],
      looking(this.eye, right, up, back),
    );
  }
  // The direction in which a point of the picture lies; x and y from -1 to 1.
  ray(x, y, aspect) {
    const { back, right, up } = this.axes();
    const open = Math.tan(0.36);
    const [sx, sy] = aspect < 1 ? [x * open, (y * open) / aspect] : [x * open * aspect, y * open];
    return back.map((v, i) => right[i] * sx + up[i] * sy - v);
  }
}

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

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
