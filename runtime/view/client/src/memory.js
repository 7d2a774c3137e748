// What the browser keeps for the next page: a page from a file may keep nothing.

export function remembered(key) {
  try {
    return localStorage.getItem(`bgc.${key}`);
  } catch {
    return null;
  }
}

export function remember(key, value) {
  try {
    localStorage.setItem(`bgc.${key}`, value);
  } catch {
    // a page from a file may not keep anything
  }
}

// Loads the page again, to `place` in it, which `cameBack` then returns.
export function comeBack(place) {
  try {
    sessionStorage.setItem("bgc.back", JSON.stringify(place));
  } catch {
    // likewise
  }
  location.reload();
}

export function cameBack() {
  try {
    const place = JSON.parse(sessionStorage.getItem("bgc.back") ?? "{}");
    sessionStorage.removeItem("bgc.back");
    return place;
  } catch {
    return {};
  }
}
