// The frames of an animation: which one is shown, and the buttons that change it.

export class Player {
  constructor(element, nFrames, fps, changed) {
    const find = name => element.querySelector(`[name=${name}]`);
    Object.assign(this, { nFrames, fps, changed, frame: 0, isPlaying: false });
    [this.button, this.slider, this.speed] = ["play", "frame", "speed"].map(find);
    this.number = element.querySelector("output");
    element.hidden = nFrames < 2;
    this.slider.max = nFrames - 1;
    this.button.onclick = () => this.toggle();
    this.slider.oninput = () => {
      this.stop();
      this.show(Number(this.slider.value));
    };
    this.speed.onchange = () => this.restart();
    this.show(0);
  }

  show(frame) {
    this.frame = frame;
    this.slider.value = frame;
    this.number.textContent = `${frame + 1} / ${this.nFrames}`;
    this.changed();
  }

  toggle() {
    if (this.isPlaying) this.stop();
    else this.start();
  }

  start() {
    if (this.nFrames < 2) return;
    this.isPlaying = true;
    this.button.textContent = "\u275a\u275a";
    this.button.setAttribute("aria-label", "Pause");
    this.restart();
    requestAnimationFrame(now => this.turn(now));
  }

  stop() {
    this.isPlaying = false;
    this.button.textContent = "\u25b6";
    this.button.setAttribute("aria-label", "Play");
  }

  restart() {
    this.from = this.frame;
    this.began = performance.now();
  }

  turn(now) {
    if (!this.isPlaying) return;
    const passed = Math.max(0, Math.floor(((now - this.began) / 1000) * this.fps * this.speed.value));
    const frame = (this.from + passed) % this.nFrames;
    if (frame !== this.frame) this.show(frame);
    requestAnimationFrame(next => this.turn(next));
  }
}
