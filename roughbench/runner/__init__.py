"""From a spec to results: plan the tasks, compute them here or in processes, assemble.

The tasks are independent, every realization draws from its own random stream, and all
averages run in the order of the realizations: results do not depend on the number of
jobs, to the last bit.
"""

from __future__ import annotations

from roughbench.engines.cluster import Cluster
from roughbench.engines.profiles import JobProfile, load_profile
from roughbench.planning.plan import check, plan, warnings
from roughbench.planning.samples import make_sample
from roughbench.planning.shares import Share, parse_share
from roughbench.rundir.folder import folder_of
from roughbench.runner.cleaning import clean
from roughbench.runner.doctor import Diagnosis, diagnose
from roughbench.runner.driver import run, run_to_file
from roughbench.runner.dry_run import TimeEstimate, preview
from roughbench.runner.inspection import RunState, status
from roughbench.runner.origins import origins
from roughbench.runner.overview import PlanRow
from roughbench.runner.partial import partial_results
from roughbench.runner.progress import Progress, ProgressListener
from roughbench.runner.provenance import Account, accounts
from roughbench.runner.reproduction import Reproduction, reproduce, spec_in
from roughbench.runner.sharing import ShareOutcome, run_share
from roughbench.runner.submission import Submission, share_jobs, submit_shares
from roughbench.runner.verification import verify
from roughbench.system import available_cores

__all__ = [
    "Account",
    "Cluster",
    "Diagnosis",
    "JobProfile",
    "PlanRow",
    "Progress",
    "ProgressListener",
    "Reproduction",
    "RunState",
    "Share",
    "ShareOutcome",
    "Submission",
    "TimeEstimate",
    "accounts",
    "available_cores",
    "check",
    "clean",
    "diagnose",
    "folder_of",
    "load_profile",
    "make_sample",
    "origins",
    "parse_share",
    "partial_results",
    "plan",
    "preview",
    "reproduce",
    "run",
    "run_share",
    "run_to_file",
    "share_jobs",
    "spec_in",
    "status",
    "submit_shares",
    "verify",
    "warnings",
]
