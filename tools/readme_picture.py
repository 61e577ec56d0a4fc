"""Make the picture of the README: python tools/readme_picture.py [SCENE] [PNG]

Runs `firstcontact check` on the scene, opens the page it writes in headless Chromium, and keeps what is seen
at the contact time.
"""

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CLI = "from firstcontact.cli import main; main()"
SIZE = "1180,700"
LARGEST = 200_000  # bytes; a README should load at once
FLAGS = [
    "--headless",
    "--no-sandbox",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--hide-scrollbars",
    "--virtual-time-budget=3000",
]


def main(scene=ROOT / "examples" / "lid.toml", target=ROOT / "docs" / "lid.png"):
    chromium = shutil.which("chromium") or shutil.which("google-chrome")
    if chromium is None:
        sys.exit("chromium not found; install it (apt-get install chromium)")
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "page.html"
        check = [sys.executable, "-c", CLI, "check", str(scene), "--html", str(page)]
        if subprocess.run(check).returncode != 1 or not page.exists():
            sys.exit(f"no contact found in {scene}, so no picture")
        Path(target).parent.mkdir(exist_ok=True)
        profile = f"--user-data-dir={folder}/profile"
        shot = [f"--screenshot={Path(target).resolve()}", f"--window-size={SIZE}", page.as_uri()]
        subprocess.run([chromium, *FLAGS, profile, *shot], check=True, stderr=subprocess.DEVNULL)
    size = Path(target).stat().st_size
    print(f"{target}: {size} bytes")
    if size > LARGEST:
        sys.exit(f"the picture is larger than {LARGEST} bytes")


if __name__ == "__main__":
    main(*sys.argv[1:])
