"""What goes to a GPU arrives whole: against a GPU that copies as late as it may. Nobody has run this on a real one."""

from types import SimpleNamespace

import numpy as np
import pytest
import torch

from ued.learning.upload import Upload, write
from ued.learning.worker import collect


class LazyGPU:
    """Copies nothing before somebody waits for it."""

    def __init__(self):
        self.asked, self.done = [], 0

    def catch_up(self, count):
        while self.done < count:
            self.asked[self.done]()
            self.done += 1


class Place:
    """Memory of a lazy GPU."""

    device = torch.device("cuda", 0)

    def __init__(self, gpu):
        self.gpu, self.content = gpu, None

    def copy_(self, source, non_blocking=False):
        assert non_blocking

        def copy():
            self.content = source.clone()

        self.gpu.asked.append(copy)


@pytest.fixture
def gpu(monkeypatch):
    gpu, empty = LazyGPU(), torch.empty

    class Event:
        after = 0

        def record(self, stream):
            assert stream == "stream of cuda:0"
            self.after = len(gpu.asked)

        def synchronize(self):
            gpu.catch_up(self.after)

    def pinned(*shape, pin_memory, **settings):
        assert pin_memory
        return empty(*shape, **settings)

    monkeypatch.setattr(torch.cuda, "Event", Event)
    monkeypatch.setattr(torch.cuda, "current_stream", lambda device: f"stream of {device}")
    monkeypatch.setattr(torch, "empty", pinned)
    return gpu


@pytest.mark.parametrize("dtype", [np.float32, np.uint8])
def test_no_buffer_is_filled_before_its_copy_has_ended(gpu, dtype):
    batches = np.arange(7 * 3 * 4, dtype=dtype).reshape(7, 3, 4)
    upload, places = Upload(torch.as_tensor(batches[0])), [Place(gpu) for _ in batches]
    waited = []
    for batch, place in zip(batches, places, strict=True):
        upload(batch, place)
        waited.append(gpu.done)
    assert waited == [0, 0, 1, 2, 3, 4, 5]  # one copy is on its way while the next buffer is filled
    gpu.catch_up(len(gpu.asked))
    assert (np.stack([place.content.numpy() for place in places]) == batches).all()


def test_a_batch_may_be_overwritten_once_it_was_sent(gpu):
    batch, place = np.ones((2, 3), np.float32), Place(gpu)
    Upload(torch.as_tensor(batch))(batch, place)
    batch[:] = 7.0  # environments may use their memory again
    gpu.catch_up(1)
    assert (place.content == 1).all()


def test_on_the_host_it_is_written():
    place = torch.zeros(2, 3)
    write(np.ones((2, 3)), place)
    assert (place == 1).all()


def test_all_students_observe_before_the_first_one_acts():
    said = []

    def worker(name):
        return SimpleNamespace(
            begin=lambda: said.append(f"{name} begins"),
            observe=lambda t: said.append(f"{name} looks {t}"),
            step=lambda t: said.append(f"{name} acts {t}"),
            finish=lambda: said.append(f"{name} ends"),
            rollout=SimpleNamespace(reward=np.zeros(2)),
            is_compiled=False,
        )

    collect([worker("a"), worker("b")])
    steps = [f"{name} {does} {t}" for t in (0, 1) for does in ("looks", "acts") for name in ("a", "b")]
    assert said == ["a begins", "b begins", *steps, "a ends", "b ends"]
