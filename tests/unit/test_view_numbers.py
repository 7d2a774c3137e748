"""The numbers of the page of `bgc view`, as its script writes them."""

import json
import shutil
import subprocess
from pathlib import Path

import pytest

CLIENT = Path(__file__).parents[2] / "runtime" / "view" / "client"
NUMBERS = CLIENT / "src" / "numbers.js"

# Value, largest size of its curve, ends of its axis, text.
ON_AXIS = [
    (3.5e-17, 3.5e-17, -120, 30, "0"),  # rounding
    (1, 7.9, 0, 8, "1.000"),  # as wide as 7.900
    (-0.03227, 1.2, -1, 21, "−0.032"),
    (21.58632, 21.59, 21.582, 21.588, "21.5863"),  # moves in its fourth decimal
    (0.02782, 0.028, -1, 13, "0.02782"),
    (12345.6, 12345.6, 0, 13000, "12346"),
    (-1e-5, 5, -5, 5, "0.000"),  # without a sign
    (2e-4, 2e-4, -1e-4, 3e-4, "0.000200"),
    (5, 5, None, None, "5"),  # an axis that is not drawn yet
    (None, 5, 0, 1, "–"),
]


@pytest.mark.skipif(shutil.which("node") is None, reason="no Node.js")
def test_values_beside_plots_keep_their_width_and_show_no_rounding():
    script = f"""
      import {{ onAxis }} from {json.dumps(NUMBERS.as_uri())};
      const cases = {json.dumps([case[:4] for case in ON_AXIS])};
      const given = (x) => x ?? NaN;
      console.log(JSON.stringify(cases.map((c) => onAxis(...c.map(given)))));
    """
    done = subprocess.run(
        ["node", "--input-type=module", "-e", script], capture_output=True, text=True, check=True
    )
    assert json.loads(done.stdout) == [case[4] for case in ON_AXIS]
