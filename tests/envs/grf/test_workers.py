"""Workers that die, hang or answer nonsense are started again, and what they played is repeated."""

import io
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from regista.envs.grf import worker, workers
from regista.envs.grf.workers import Episode, GrfError, Workers, grf_python
from tests.envs.grf.fixtures import SCENE, fake_python

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[3]
ACTIONS = np.random.default_rng(0).integers(0, 19, (12, 3, worker.ROWS))  # [T, K, 22]


def played(pool: Workers, steps: int = 12) -> np.ndarray:
    """Play three episodes, and return what was seen at the start and after every step: OBSERVED `[T + 1, K]`."""
    episodes = [Episode(SCENE, seed) for seed in range(3)]
    seen = [pool.begin(episodes)] + [pool.play(episodes, actions) for actions in ACTIONS[:steps]]
    pool.close()
    return np.array(seen)


@pytest.fixture(name="undisturbed")
def _undisturbed(tmp_path):
    return played(Workers(fake_python(tmp_path), 1))


def test_episodes_do_not_depend_on_the_number_of_workers(tmp_path, undisturbed):
    assert played(Workers(fake_python(tmp_path), 2)).tobytes() == undisturbed.tobytes()
    assert not (undisturbed[0] == undisturbed[-1]).any()


@pytest.mark.sample(2)
@pytest.mark.parametrize("what", ["die", "hang", "garbage"])
def test_an_episode_is_repeated_where_its_worker_is_gone(tmp_path, monkeypatch, undisturbed, what):
    monkeypatch.setattr(workers, "ANSWER_SECONDS", 2.0)
    monkeypatch.setattr(workers, "STEP_SECONDS", 0.0)
    pool = Workers(fake_python(tmp_path, do=what, at=22, once=str(tmp_path / "done")), 1)
    seen = played(pool)
    assert (tmp_path / "done").exists()
    assert seen.tobytes() == undisturbed.tobytes()


def test_a_worker_that_always_dies_is_given_up_with_its_last_words(tmp_path):
    with pytest.raises(
        GrfError, match=r"failed 3 times during the same step: the GRF worker process died.*under water"
    ):
        played(Workers(fake_python(tmp_path, do="die", at=1), 1))


def test_what_the_engine_refuses_is_told_and_no_death(tmp_path):
    with pytest.raises(GrfError, match="the referee is ill"):
        played(Workers(fake_python(tmp_path, do="refuse", at=1), 1))


def test_a_pool_goes_on_after_an_error(tmp_path, undisturbed):
    pool = Workers(fake_python(tmp_path, do="refuse", at=10, once=str(tmp_path / "done")), 1)
    episodes = [Episode(SCENE, seed) for seed in range(3)]
    pool.begin(episodes)
    for actions in ACTIONS[:3]:
        pool.play(episodes, actions)
    with pytest.raises(GrfError, match="referee"):
        pool.play(episodes, ACTIONS[3])
    assert pool.play(episodes, ACTIONS[3]).tobytes() == undisturbed[4].tobytes()
    pool.close()


def test_a_worker_of_another_version_is_refused(tmp_path):
    with pytest.raises(GrfError, match="uses protocol version 99, expected 1"):
        played(Workers(fake_python(tmp_path, do="version"), 1))


def test_a_program_that_is_no_worker_is_given_up(tmp_path):
    script = tmp_path / "python"
    script.write_text("#!/bin/sh\necho hello\n")
    script.chmod(0o755)
    with pytest.raises(GrfError, match="3 times"):
        played(Workers(script, 1))


def test_a_repetition_that_shows_something_else_is_an_error(tmp_path):
    pool = Workers(fake_python(tmp_path), 1)
    episode = Episode(SCENE, 1)
    pool.begin([episode])
    pool.play([episode], ACTIONS[0][:1])
    episode.seed = 2
    pool.close()
    with pytest.raises(GrfError, match="did not replay an episode identically"):
        pool.play([episode], ACTIONS[1][:1])
    pool.close()


def test_engines_are_given_up_and_their_episodes_repeated(tmp_path, monkeypatch, undisturbed):
    monkeypatch.setattr(workers, "MOST_ENGINES", 1)
    pool = Workers(fake_python(tmp_path), 1)
    episodes = [Episode(SCENE, seed) for seed in range(3)]
    for episode in episodes:
        pool.begin([episode])
    for step, actions in enumerate(ACTIONS):
        for number, episode in enumerate(episodes):
            seen = pool.play([episode], actions[number : number + 1])
            assert seen[0].tobytes() == undisturbed[step + 1, number].tobytes()
            assert len(pool.processes[0].held) == 1
    pool.close()


def test_closing_ends_the_processes(tmp_path):
    pool = Workers(fake_python(tmp_path), 2)
    pool.begin([Episode(SCENE, 0), Episode(SCENE, 1)])
    processes = [each.process for each in pool.processes]
    pool.close()
    assert all(process.poll() is not None for process in processes)


PLAY = """
import os, sys, time
import numpy as np
from regista.envs.grf import workers
from tests.envs.grf.fixtures import SCENE
python, then = sys.argv[1:]
workers.ANSWER_SECONDS, workers.STEP_SECONDS = 3.0, 0.0
pool = workers.shared_workers(python, 1)
episode = workers.Episode(SCENE, 0)
pool.begin([episode])
print(pool.processes[0].process.pid, flush=True)
if then == "play":
    pool.play([episode], np.zeros((1, 22), int))
elif then == "wait":
    time.sleep(100)
elif then == "fork":
    if not os.fork():
        time.sleep(30)  # with a copy of the pipe by which the worker is asked
    time.sleep(100)
"""


def start_parent(python: Path, then: str) -> tuple[subprocess.Popen, int]:
    """Start a process that plays; return it, and the number of its worker."""
    words = [sys.executable, "-c", PLAY, str(python), then]
    root = Path(__file__).parents[3]
    parent = subprocess.Popen(words, cwd=root, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    assert parent.stdout is not None
    return parent, int(parent.stdout.readline())


@pytest.mark.sample(3)
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT, signal.SIGTERM, None])
def test_no_worker_outlives_us(tmp_path, how):
    """However we end, by a signal or by ourselves."""
    parent, pid = start_parent(fake_python(tmp_path), "end" if how is None else "wait")
    if how is not None:
        parent.send_signal(how)
    parent.wait()
    assert ends(pid)


def test_not_even_a_hung_worker_outlives_us(tmp_path):
    parent, pid = start_parent(fake_python(tmp_path, do="hang", at=0, once=str(tmp_path / "done")), "play")
    until = time.monotonic() + 20
    while not (tmp_path / "done").exists():
        assert time.monotonic() < until
        time.sleep(0.01)
    parent.kill()
    parent.wait()
    assert is_running(pid)
    assert ends(pid)


def test_a_worker_does_not_outlive_us_where_another_process_has_a_copy_of_its_pipe(tmp_path):
    parent, pid = start_parent(fake_python(tmp_path), "fork")
    time.sleep(0.5)
    forked = [each for each in children_of(parent.pid) if each != pid]
    parent.kill()
    parent.wait()
    assert len(forked) == 1 and ends(pid, 5.0) and is_running(forked[0])
    os.kill(forked[0], signal.SIGKILL)


def children_of(parent: int) -> list[int]:
    """Return the processes that a process has started."""
    found = []
    for file in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):  # it has ended meanwhile
            if int(file.read_text().rpartition(")")[2].split()[1]) == parent:
                found.append(int(file.parent.name))
    return found


def test_a_script_that_starts_the_engine_ends_with_it(tmp_path):
    inner = fake_python(tmp_path)
    script = tmp_path / "outer"
    script.write_text(f'#!/bin/sh\n{inner} "$@"\nexit 0\n')  # no exec: the engine is its child
    script.chmod(0o755)
    pool = Workers(script, 1)
    pool.begin([Episode(SCENE, 0)])
    outer = pool.processes[0].process.pid
    inside = children_of(outer)
    pool.close()
    assert inside and all(ends(pid, 3.0) for pid in inside)


def test_a_forked_process_does_not_end_the_workers_of_its_parent(tmp_path):
    pool = Workers(fake_python(tmp_path), 1)
    pool.enter()
    pool.begin([Episode(SCENE, 0)])
    forked = os.fork()
    if not forked:
        pool.leave()
        os._exit(0)
    os.waitpid(forked, 0)
    assert pool.processes[0].process.poll() is None
    pool.leave()
    assert pool.processes[0].process is None


def ends(pid: int, seconds: float = 20.0) -> bool:
    """Return whether a process ends within some seconds."""
    until = time.monotonic() + seconds
    while is_running(pid) and time.monotonic() < until:
        time.sleep(0.05)
    return not is_running(pid)


def is_running(pid: int) -> bool:
    """Return whether there is such a process, but for one that is dead and not yet collected."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_where_the_engine_is_missing_one_sentence_says_what_to_do(tmp_path, monkeypatch):
    monkeypatch.delenv(workers.VARIABLE, raising=False)
    monkeypatch.setenv(workers.HOME, str(tmp_path))
    with pytest.raises(
        GrfError, match=r"not installed: no .*bin/python\. `make grf` .*docs/howto/real-engine.*--grf-python"
    ):
        grf_python()
    monkeypatch.setenv(workers.VARIABLE, sys.executable)
    assert grf_python() == Path(sys.executable)
    with pytest.raises(GrfError, match="no /nowhere/python"):
        grf_python("/nowhere/python")


def test_messages_come_back_as_they_were_sent():
    arrays = {"actions": np.arange(6).reshape(2, 3), "observed": np.zeros(2, worker.OBSERVED)}
    arrays["observed"]["score"] = [[1, 2], [3, 4]]
    message, found = worker.unpack(io.BytesIO(worker.pack({"do": "step", "slots": [1, 2]}, **arrays)).read)
    assert message == {"do": "step", "slots": [1, 2]}
    assert all((found[name] == arrays[name]).all() and found[name].dtype == arrays[name].dtype for name in arrays)


@pytest.mark.parametrize(
    "damage",
    [
        lambda data: b"nonsense" + data,
        lambda data: data[:4] + b"\xff\xff\xff\xff" + data[8:],
        lambda data: data.replace(b'"<i8"', b'"<q9"'),
        lambda data: data.replace(b"[2, 3]", b"[2, 2]"),
        lambda data: data.replace(b'{"do"', b'{"do,'),
    ],
)
def test_what_is_no_message_is_refused(damage):
    data = worker.pack({"do": "step"}, actions=np.arange(6).reshape(2, 3))
    with pytest.raises(worker.ProtocolError):
        worker.unpack(io.BytesIO(damage(data)).read)


def test_several_actions_are_digits():
    assert worker.digits(0) == [0]
    assert worker.digits(19) == [19]
    assert worker.digits((5 * 20 + 0) * 20 + 13) == [5, 0, 13]


@pytest.mark.parametrize(("version", "code", "said"), [("3.11", 9, ""), ("3.12", 1, "3.8 to 3.11, as in Debian 12")])
def test_the_installer_takes_the_pythons_that_the_engine_can_be_built_for(tmp_path, version, code, said):
    python = tmp_path / "python"
    info = f"import sys; sys.version_info = ({version.replace('.', ', ')}); exec(sys.argv[1])"
    python.write_text(f'#!/bin/sh\n[ "$1" = -m ] && exit 9\n[ "$1" = -c ] && exec {sys.executable} -c "{info}" "$2"\n')
    python.chmod(0o755)
    where = {"REGISTA_GRF_SYSTEM_PYTHON": str(python), "REGISTA_GRF_HOME": str(tmp_path / "home")}
    script = ROOT / "envs" / "grf" / "install.sh"
    done = subprocess.run(["sh", script, "--environment"], env=os.environ | where, capture_output=True, text=True)
    assert done.returncode == code and said in done.stderr and "Error" not in done.stderr
