"""The file system of a path."""

from pathlib import Path

MOUNTS = Path("/proc/self/mountinfo")

NETWORK = frozenset(
    {
        *("9p", "acfs", "afs", "beegfs", "ceph", "cifs", "davfs", "glusterfs", "gpfs", "lustre", "ncpfs"),
        *("nfs", "nfs4", "orangefs", "panfs", "pvfs2", "smb3", "smbfs", "virtiofs", "vboxsf"),
        *(
            "fuse.ceph",
            "fuse.cifs",
            "fuse.davfs",
            "fuse.glusterfs",
            "fuse.rclone",
            "fuse.s3fs",
            "fuse.smbnetfs",
        ),
        *("fuse.sshfs", "fuse.vmhgfs-fuse"),
    }
)
"""Types of file systems whose disk, or whose other users, are on another machine."""


def file_system_of(path: Path) -> str:
    """Return the type of the file system of a path, as in /proc/self/mountinfo; empty if it is not known.

    Examples
    --------
    >>> file_system_of(Path("/proc/self"))
    'proc'
    """
    try:
        lines = MOUNTS.read_text("utf-8", "surrogateescape").splitlines()
    except OSError:
        return ""  # not Linux
    # The last mount of a place hides those before it.
    types = dict(map(_mount_in, lines))
    resolved = path.resolve()
    return next((types[place] for place in (resolved, *resolved.parents) if place in types), "")


def on_network(path: Path) -> bool:
    """Return whether a path is on a disk of another machine."""
    return file_system_of(path) in NETWORK


def _mount_in(line: str) -> tuple[Path, str]:
    """Return where a file system is mounted and its type, from a line as described in proc(5)."""
    mount, _, rest = line.partition(" - ")
    place = mount.split(" ")[4].encode("utf-8", "surrogateescape").decode("unicode_escape")  # \040 is a blank
    return Path(place), rest.split(" ")[0]
