"""Fits of stored recordings as jobs; results are kept on disk."""

from __future__ import annotations

from platform_daemon.core.web.job_routes import JobRoutes

FITS = JobRoutes("fit", lambda job: {"recording": f"/recordings/{job.request.recording}"})
router = FITS.router()


FITS.add_job_routes(router)
