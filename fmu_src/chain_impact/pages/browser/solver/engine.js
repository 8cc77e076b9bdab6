// The part of the page that sends requests to the worker.

export class Engine {
  #number = 0;
  #waiting = new Map();
  #begun;
  #fault; // whether the worker has ended, after which it does not answer
  #ended = false;

  /**
   * A worker that runs the program at an address for a scene; `module` is a promise of the compiled kernel, which all
   * workers share.
   */
  constructor(address, scene, module) {
    this.worker = new Worker(address);
    this.worker.onmessage = ({ data }) => this.#take(data);
    this.worker.onerror = ({ message }) => this.#fail(new Error(message || "the browser does not let it begin"));
    this.#begun = module.then((compiled) => this.worker.postMessage({ kind: "scene", scene, module: compiled }));
  }

  /**
   * Return the result of a request; null if a newer request has replaced it, or the worker has ended. `progress` is called
   * with the finished fraction.
   */
  async ask(kind, values, options = {}, progress = () => {}) {
    await this.#begun;
    if (this.#fault) throw this.#fault;
    if (this.#ended) return null;
    this.#number += 1;
    const number = this.#number;
    return new Promise((give, fail) => {
      this.#waiting.set(number, { give, fail, progress });
      this.worker.postMessage({ kind, number, values, options });
    });
  }

  /** End the worker; open requests get no result. */
  end() {
    this.#ended = true;
    this.worker.terminate();
    this.#waiting.forEach(({ give }) => give(null));
  }

  #fail(error) {
    this.worker.terminate();
    this.#fault = error;
    this.#waiting.forEach(({ fail }) => fail(error));
    this.#waiting.clear();
  }

  #take({ number, done, result, fault }) {
    const { give, fail, progress } = this.#waiting.get(number);
    if (done !== undefined) {
      progress(done);
      return;
    }
    this.#waiting.delete(number);
    if (fault) fail(new Error(fault));
    else give(result);
  }
}
