// The grips as one stop of the key Tab: Page Down and Page Up lead from grip to grip.

const GRIP_KINDS = ["joint", "site", "velocity", "wall"]; // kinds of grips in the order in which Page Down reaches them
const STEPS_AMONG_GRIPS = { PageDown: 1, PageUp: -1 };

export class HandleStops {
  #last = "joint 0"; // the grip that had the focus last, which the key Tab reaches

  /** Listen to the keys in the `element` that contains the grips. */
  constructor(element) {
    this.element = element;
    element.addEventListener("focusin", ({ target }) => {
      this.#last = target.dataset.grip ?? this.#last;
      this.show();
    });
    element.addEventListener("keydown", (event) => {
      const [grips, step] = [this.#grips, STEPS_AMONG_GRIPS[event.key]];
      const at = grips.indexOf(event.target);
      if (!step || at < 0) return;
      event.preventDefault();
      grips[(at + step + grips.length) % grips.length].focus({ preventScroll: true });
    });
  }

  /** Let the key Tab reach one grip only; call this after the grips have been drawn. */
  show() {
    const grips = this.#grips;
    const stop = grips.find(({ dataset: { grip } }) => grip === this.#last) ?? grips[0];
    grips.forEach((grip) => grip.setAttribute("tabindex", grip === stop ? 0 : -1));
  }

  /** Return the elements of all grips in the order of GRIP_KINDS. */
  get #grips() {
    const kindOf = ({ dataset: { grip } }) => GRIP_KINDS.indexOf(grip.split(" ")[0]);
    return [...this.element.querySelectorAll("[data-grip]")].sort((one, other) => kindOf(one) - kindOf(other));
  }
}
