// Pointer, wheel, fingers and keys change the view, as `viewer/controls.py` does in the window.
import { clamp } from "./matrices.js";
import { NO_OVERRIDES, STYLE_KEYS, nextBackground } from "./style.js";

const LEFT = 0, MIDDLE = 1, RIGHT = 2;
const LINE_UNITS = 16, PAGE_UNITS = 400; // of a wheel that counts in lines or pages, in pixels

//   initial : orbit(aspect) and points() of the first view, the layer whose style keys cycle from, its background
//   changed : called when the picture is another
export class Controls {
  constructor(canvas, initial, constants, changed) {
    Object.assign(this, { canvas, initial, constants, changed });
    this.orbit = null; // none for what the first camera sees, in a window of any shape
    this.overrides = NO_OVERRIDES;
    this.note = "";
    this.fingers = new Map();
    canvas.addEventListener("pointerdown", event => this.press(event));
    canvas.addEventListener("pointermove", event => this.move(event));
    for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, event => this.release(event));
    canvas.addEventListener("contextmenu", event => event.preventDefault());
    canvas.addEventListener("wheel", event => this.wheel(event), { passive: false });
  }

  get size() {
    return [this.canvas.clientWidth, this.canvas.clientHeight];
  }

  get aspect() {
    return this.size[0] / this.size[1];
  }

  get shownOrbit() {
    return this.orbit ?? this.initial.orbit(this.aspect);
  }

  show(orbit, note = "") {
    Object.assign(this, { orbit, note });
    this.changed();
  }

  // A place of the window, in its pixels, as NDC.
  toNdc([x, y]) {
    return [(2 * x) / this.size[0] - 1, 1 - (2 * y) / this.size[1]];
  }

  press(event) {
    if (this.fingers.size === 2) return;
    this.canvas.setPointerCapture?.(event.pointerId);
    const pans = event.button === RIGHT || event.button === MIDDLE || event.shiftKey;
    if (![LEFT, MIDDLE, RIGHT].includes(event.button)) return;
    this.fingers.set(event.pointerId, { at: [event.offsetX, event.offsetY], pans });
  }

  release(event) {
    this.fingers.delete(event.pointerId);
  }

  move(event) {
    const finger = this.fingers.get(event.pointerId);
    if (!finger) return;
    if (!event.buttons) { // released elsewhere, without an event
      this.release(event);
      return;
    }
    const start = finger.at, end = [event.offsetX, event.offsetY];
    finger.at = end;
    const other = [...this.fingers.entries()].find(([id]) => id !== event.pointerId)?.[1].at;
    if (other) this.pinch(start, end, other);
    else if (finger.pans) this.show(this.shownOrbit.panned(this.toNdc(start), this.toNdc(end), this.aspect));
    else {
      const perPixel = this.constants.RADIANS_PER_HEIGHT / this.size[1];
      this.show(this.shownOrbit.rotated((end[0] - start[0]) * perPixel, (end[1] - start[1]) * perPixel));
    }
  }

  // Two fingers move the models, and bring them nearer as they part.
  pinch(start, end, other) {
    const middle = at => [(at[0] + other[0]) / 2, (at[1] + other[1]) / 2];
    const apart = at => Math.max(1, Math.hypot(at[0] - other[0], at[1] - other[1]));
    const moved = this.shownOrbit.panned(this.toNdc(middle(start)), this.toNdc(middle(end)), this.aspect);
    this.show(moved.zoomed(apart(start) / apart(end), this.toNdc(middle(end)), this.aspect));
  }

  wheel(event) {
    event.preventDefault();
    const unit = [1, LINE_UNITS, PAGE_UNITS][event.deltaMode] / this.constants.UNITS_PER_NOTCH;
    this.zoom(event.deltaY * unit, this.toNdc([event.offsetX, event.offsetY]));
  }

  zoom(notches, at) {
    const { MAX_NOTCHES, ZOOM_PER_NOTCH } = this.constants;
    this.show(this.shownOrbit.zoomed(ZOOM_PER_NOTCH ** clamp(notches, -MAX_NOTCHES, MAX_NOTCHES), at, this.aspect));
  }

  // Applies a key; says whether it has one.
  key(name, hasShift = false) {
    const { constants, initial } = this, { ROTATION_KEYS, SIDE_KEYS } = constants;
    const style = ([overrides, note]) => {
      Object.assign(this, { overrides, note });
      this.changed();
    };
    if (name in ROTATION_KEYS) this.show(this.shownOrbit.rotated(...ROTATION_KEYS[name]));
    else if (name in SIDE_KEYS) {
      const side = SIDE_KEYS[name][Number(hasShift)];
      this.show(this.shownOrbit.seenFrom(side, initial.points(), this.aspect), `view: ${side}`);
    } else if (name in STYLE_KEYS) style(STYLE_KEYS[name](this.overrides, initial.layer, constants));
    else if (["+", "=", "-", "_"].includes(name)) this.zoom("-_".includes(name) ? 1 : -1, [0, 0]);
    else if (name === "b") style(nextBackground(this.overrides, initial.background, constants));
    else if (name === "p") {
      const isParallel = !this.shownOrbit.isParallel;
      this.show(this.shownOrbit.with({ isParallel }), isParallel ? "parallel" : "perspective");
    } else if (name === "r" || name === "Home") this.show(null, "the first view");
    else if (name === "Backspace") style([NO_OVERRIDES, "the first style"]);
    else return false;
    return true;
  }
}
