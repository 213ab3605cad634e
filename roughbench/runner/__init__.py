"""From a spec to results: plan the tasks, compute them here or in processes, assemble.

The tasks are independent, every realization draws from its own random stream, and all
averages run in the order of the realizations: results do not depend on the number of
jobs, to the last bit.
"""

from __future__ import annotations

from roughbench.runner.driver import available_cores, run
from roughbench.runner.plan import check, plan
from roughbench.runner.progress import Progress, Report
from roughbench.runner.samples import make_sample

__all__ = ["Progress", "Report", "available_cores", "check", "make_sample", "plan", "run"]
