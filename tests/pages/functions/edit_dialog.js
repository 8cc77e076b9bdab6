// Functions that tests/pages/test_edit_dialog.py runs in a page.

export const dropInPage = ([name, text]) => {
  const data = new DataTransfer();
  data.items.add(new File([text], name));
  document.body.dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
};
