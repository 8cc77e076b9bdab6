// Functions that tests/pages/test_parameter_list.py runs in a page.

/** Return the number of fields in the list of all parameters that lie in the window, where nothing covers them. */
export const rowsInSight = () => [...document.querySelectorAll(".parameter :is(input, select)")].filter((field) => {
  const { left, top, width, height } = field.getBoundingClientRect();
  return document.elementFromPoint(left + width / 2, top + height / 2) === field;
}).length;
