// Buttons of a job: pause, resume, cancel, answer, again.
import { download, send } from "../api.js";
import { actionButton } from "../dom.js";
import { pathOfJob, refresh } from "../live.js";

/** May this tab start and change jobs?  The daemon checks it in any case. */
export function mayOperate() {
  return ["operator", "admin"].includes(document.body.dataset.role ?? "");
}

export function mayGovern() {
  return document.body.dataset.role === "admin";
}

/** What can be done with a job now. @param {any} job @param {() => void} [after] */
export function jobActions(job, after = () => {}) {
  const path = pathOfJob(job.id);
  const disabled = !mayOperate();
  const title = disabled ? "Needs a token of an operator" : null;
  /** @param {string} text @param {() => Promise<any>} action */
  const button = (text, action) =>
    actionButton(text, async () => {
      await action();
      refresh();
      after();
    }, { disabled, title });
  const ended = ["done", "failed", "cancelled"].includes(job.state);
  const pauses = ["acquisition", "procedure", "reproduction"].includes(job.kind);
  return [
    job.question && button("Done, go on", () => send("POST", `${path}/continue`)),
    !ended && pauses && !job.paused && button("Pause", () => send("POST", `${path}/pause`)),
    !ended && pauses && job.paused && button("Resume", () => send("POST", `${path}/resume`)),
    !ended && button("Cancel", () => send("DELETE", path)),
    ended && ["acquisition", "reproduction"].includes(job.kind) && job.state !== "done" && button("Measure what is missing", () => send("POST", `${path}/resume`)),
  ].filter(Boolean);
}

/** A button for the page of a job's report. @param {string} path of the job */
export function reportButton(path) {
  return actionButton("Download the report", () => download(`${path}/report`, `${path.split("/").at(-1)}.html`, "text/html"));
}
