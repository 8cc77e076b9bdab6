// The words for inputs and for the numbers of signals, in place of their names.

const INPUTS = [
  [/^joint\[(\d+)\]\.torque$/, "Torque of joint $1"],
  [/^joint\[(\d+)\]\.target_(angle|velocity)$/, "Target $2 of joint $1"],
  [/^slider\.force$/, "Force on the slider"],
  [/^slider\.target_(position|velocity)$/, "Target $1 of the slider"],
  [/^tip\.force\.([xy])$/, "Force on the tip, $1"],
  [/^base\.([xy])$/, "Position of the base, $1"],
  [/^base\.v([xy])$/, "Velocity of the base, $1"],
  [/^base\.a([xy])$/, "Acceleration of the base, $1"],
  [/^wall\.(.+)\.displacement$/, "Displacement of $1"],
  [/^wall\.(.+)\.velocity$/, "Velocity of $1"],
  [/^wall\.(.+)\.acceleration$/, "Acceleration of $1"],
  [/^wall\.(.+)\.belt_speed$/, "Belt speed of $1"],
];

/** Return the words for an input: "Force on the tip, x" for tip.force.x. */
export function inputText(name) {
  const [pattern, words] = INPUTS.find(([one]) => one.test(name)) ?? [name, name];
  return name.replace(pattern, words);
}

/** Return the words for a number of a signal: "push: value 1" for the key value[1] of the signal push. */
export function signalText(signal, key) {
  return `${signal}: ${key.replaceAll("_", " ").replace(/\[(\d+)\]$/, "\u00a0$1")}`;
}
