"""Compiles the kernels into the wheel, for every processor of this kind, so that nobody who installs it waits for that.

An editable install compiles on first use, as does a wheel built where compiling fails.
"""

from __future__ import annotations

import importlib.metadata
import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

WITHIN = "firstcontact/kernels/compiled"
# Bars of an ordinary laptop are a minute; a machine shared by many may take much longer.
LIMIT = 1800.0
# It has no threads and imports once; elsewhere than on Linux, libraries of the system do not outlive a fork.
BEGUN_BY = "fork" if sys.platform == "linux" else "spawn"
COMPILE = f"from firstcontact.warmup import cores, warm_together; warm_together(cores(), begun_by={BEGUN_BY!r})"


class CompiledKernels(BuildHookInterface):  # type: ignore[type-arg]
    """What hatchling calls before it packs a wheel, and after."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        self._folder = tempfile.mkdtemp(prefix="firstcontact-kernels-")
        if version == "editable":
            return
        try:
            self._run(COMPILE)
        except (OSError, subprocess.SubprocessError) as error:
            said = getattr(error, "stderr", None) or ""
            self.app.display_error(f"{said}\nKERNELS NOT COMPILED, THIS WHEEL COMPILES THEM ON FIRST USE: {error}")
            return
        # What Python calls: the kernels that those call are compiled into them.
        for file in sorted(Path(self._folder).glob("*/*.nbc")):
            build_data["force_include"][str(file)] = f"{WITHIN}/{file.parent.name}/{file.name}"
        # Compiled code is for one version of Numba and of Python, and one kind of machine.
        build_data["dependencies"] += [f"{name}=={importlib.metadata.version(name)}" for name in ("numba", "llvmlite")]
        build_data["pure_python"] = False
        platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
        build_data["tag"] = f"cp{sys.version_info.major}{sys.version_info.minor}-none-{platform}"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        shutil.rmtree(self._folder, ignore_errors=True)

    def _run(self, program: str) -> None:
        """Compile for any processor."""
        environment = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")} | {
            "FIRSTCONTACT_CACHE": self._folder,
            "PYTHONPATH": os.pathsep.join([str(Path(self.root) / "src"), os.environ.get("PYTHONPATH", "")]),
            "NUMBA_CPU_NAME": "generic",
            "NUMBA_CPU_FEATURES": "",
            "OPENBLAS_NUM_THREADS": "1",  # nothing is multiplied here
        }
        subprocess.run(
            [sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=True, timeout=LIMIT
        )
