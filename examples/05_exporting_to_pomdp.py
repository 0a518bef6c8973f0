"""Export a model to Cassandra's .pomdp format, which SARSOP and other solvers read."""

from pathlib import Path
from tempfile import TemporaryDirectory

from beltsort.models import paper


def main() -> None:
    """Write the paper's instance with one position, and print the first lines of the file."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "paper.pomdp"
        paper().with_positions(1).to_pomdp(path)
        lines = [line for line in path.read_text().splitlines() if line and not line.startswith("#")]
    print("\n".join(line[:100] for line in lines[:5]))


if __name__ == "__main__":
    main()
