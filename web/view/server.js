// What the page asks of the program that serves it (docs/reference/view.md).

// Only this program's own page has it: no other site can steer the rendering.
const kToken = document.querySelector("meta[name=metrolux-token]").content;

async function ask(path, options = {}) {
  const response = await fetch(path, { ...options, headers: { "X-Metrolux-Token": kToken } });
  if (!response.ok) throw Object.assign(new Error(await response.text()), { status: response.status });
  return response;
}

export const about = async () => (await ask("about")).json();

export async function command(name, values = {}) {
  await ask("command", { method: "POST", body: JSON.stringify({ do: name, ...values }) });
}

export async function frame(side, layer) {
  const response = await ask(`frame?side=${side}&layer=${layer}`);
  if (response.status === 204) throw Object.assign(new Error("there is nothing yet"), { status: 204 });
  const info = JSON.parse(response.headers.get("X-Frame"));
  return { ...info, side, layer, halfs: new Uint16Array(await response.arrayBuffer()) };
}

// Of the place in a picture of this size.
export const pixel = async (side, layer, x, y, width, height) =>
  (await ask(`pixel?side=${side}&layer=${layer}&x=${x}&y=${y}&width=${width}&height=${height}`)).json();

const pause = (milliseconds) => new Promise((resolve) => setTimeout(resolve, milliseconds));
const shown = () =>
  new Promise((resolve) => {
    if (!document.hidden) return resolve();
    const look = () => document.hidden || (document.removeEventListener("visibilitychange", look), resolve());
    document.addEventListener("visibilitychange", look);
  });

// Calls `changed` with every new state, and `lost` when the program does not answer.
export async function follow(changed, lost) {
  let after = "";
  for (;;) {
    await shown();
    let state = null;
    try {
      state = await (await ask(`state${after}`)).json();
    } catch (problem) {
      lost(problem);
      await pause(1000);
      continue;
    }
    after = `?after=${state.version}`;
    changed(state);
    if (state.phase === "ended") return;
  }
}
