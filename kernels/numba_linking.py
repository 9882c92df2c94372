"""Linking of kernels that call each other: machine code is generated once per entry point, not once per kernel.

Numba makes a program of each compiled function: it links and optimizes all callees, generates machine code, and wraps
the function for calls from Python. So a chain of n calls is optimized n times. Most of our kernels are only called by
other kernels. So a `Kernel` has two forms. The part, which other kernels link, is the output of Numba's front end. The
program is compiled when Python calls the kernel. This saves half of the first compilation; the machine code of
functions called from Python is the same.
Read next: `kernels.jit`, which makes kernels; `kernels.notices`, which shows the progress.
"""

from __future__ import annotations

import fcntl
import gc
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from functools import partial
from typing import IO, Any

from numba.core import errors
from numba.core.codegen import JITCodeLibrary, JITCPUCodegen
from numba.core.compiler import Compiler
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import CPUDispatcher
from numba.core.sigutils import normalize_signature
from numba.core.types.functions import BaseFunction

from regista.kernels import notices
from regista.kernels.numba_cache import KernelCache

# Compiler stages for features that kernels never use: contexts, closures, exceptions, array expressions, inlining.
NEEDLESS = {
    *("WithLifting", "InlineClosureLikes", "RewriteDynamicRaises", "MakeFunctionToJitFunction", "InlineInlinables"),
    *("FindLiterallyCalls", "LiteralUnroll", "LiteralPropagationSubPipelinePass", "InlineOverloads"),
    "NopythonRewrites",
}
GARBAGE = 100_000  # allocations minus frees before young objects are collected; Python's 700 costs 10%


class _PartLibrary(JITCodeLibrary):
    """The code of one part, neither optimized nor compiled; it links all parts that it needs into one module."""

    def _optimize_functions(self, ll_module: Any) -> None:
        ll_module.data_layout = self._codegen._data_layout

    def finalize(self) -> None:
        self._raise_if_finalized()
        self._finalized = True

    def _get_module_for_linking(self) -> Any:
        self._ensure_finalized()
        if self._shared_module is None:
            libraries = _below(self)
            modules = [library._own_module() for library in libraries if isinstance(library, _PartLibrary)]
            while len(modules) > 1:  # in pairs: each link makes LLVM read the whole destination module
                for module, other in zip(modules[::2], modules[1::2], strict=False):
                    module.link_in(other)
                modules = modules[::2]
            for library in libraries:
                if not isinstance(library, _PartLibrary):
                    modules[0].link_in(library._get_module_for_linking(), preserve=True)
            self._shared_module = modules[0]
        return self._shared_module

    def _own_module(self) -> Any:
        """Return a copy of the module of this part alone; several programs may contain its functions."""
        module = self._final_module.clone()
        for function in module.functions:
            if not function.is_declaration and function.linkage.name == "external":
                function.linkage = "weak_odr"  # kept even while it has no caller
        return module


def _below(top: _PartLibrary) -> list[Any]:
    """Return a part and all libraries that it needs, each once."""
    libraries: dict[int, Any] = {id(top): top}
    pending = list(top._linking_libraries)
    while pending:
        library = pending.pop()
        if id(library) not in libraries:
            libraries[id(library)] = library
            if isinstance(library, _PartLibrary):
                pending += library._linking_libraries
    return list(libraries.values())


class _ProgramLibrary(JITCodeLibrary):
    """The code of a program: only its own entry calls the linked functions, so the optimizer may do more."""

    def _optimize_final_module(self) -> None:
        notices.generating()
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage.name in ("linkonce_odr", "weak_odr"):
                function.linkage = "internal"
        super()._optimize_final_module()


class _PartCodegen(JITCPUCodegen):
    """Numba's code generator with the same engine, but for libraries of parts, which have no address."""

    _library_class = _PartLibrary

    def __init__(self, usual: Any) -> None:
        vars(self).update(vars(usual))
        self.usual = usual

    def set_env(self, name: str, environment: Any) -> None:
        """Do nothing: a function's Python objects are only needed for errors, and kernels never raise."""


class _PartCompiler(Compiler):
    """Numba's compiler up to its intermediate representation."""

    def __init__(self, typingctx: Any, targetctx: Any, library: Any, *rest: Any) -> None:
        super().__init__(typingctx, targetctx, library, *rest)
        context = self.state.targetctx
        self.state.targetctx = context.subtarget(_internal_codegen=_PartCodegen(context.codegen()))

    def define_pipelines(self) -> list[Any]:
        pipelines = super().define_pipelines()
        for pipeline in pipelines:
            pipeline.passes = [(step, what) for step, what in pipeline.passes if step.__name__ not in NEEDLESS]
            pipeline.finalize()
            pipeline._runPass = partial(_run_pass, pipeline._analysis)
        return pipelines

    def compile_extra(self, func: Any) -> Any:
        result = super().compile_extra(func)
        notices.compiled_part(func)
        return result


def _run_pass(analysis: Any, _: int, step: Any, state: Any) -> None:
    """Run one pass without Numba's event, which formats the types of all arguments."""
    step.analysis = analysis
    step.run_pass(state)


class _ProgramCompiler(_PartCompiler):
    """Numba's compiler for programs; bodies of parallel loops and their wrappers become parts."""

    def compile_extra(self, func: Any) -> Any:
        library = self.state.library = _ProgramLibrary(self.state.targetctx.codegen().usual, func.__qualname__)
        library.enable_object_caching()
        with notices.compiling(func):
            return super().compile_extra(func)


@contextmanager
def _in_haste() -> Iterator[None]:
    """Skip Numba's repeated work: typing of operators, coloring of errors that it discards, garbage collection."""
    operators: Any = BaseFunction
    colors: Any = type(errors.termcolor())
    typed, colored, thresholds = operators.get_call_type, colors.errmsg, gc.get_threshold()
    signatures: dict[Any, Any] = {}

    def typed_once(function: Any, context: Any, args: Any, kws: dict[str, Any]) -> Any:
        key = function, context, args, *kws.items()
        if key not in signatures:
            signatures[key] = typed(function, context, args, kws)
        return signatures[key]

    with global_compiler_lock:
        operators.get_call_type, colors.errmsg = typed_once, lambda _, message: message
        gc.set_threshold(GARBAGE, *thresholds[1:])
        try:
            yield
        finally:
            operators.get_call_type, colors.errmsg = typed, colored
            gc.set_threshold(*thresholds)


class _Part(CPUDispatcher):
    """The form of a kernel that other kernels link."""

    def compile(self, sig: Any) -> Any:
        this: Any = self  # untyped, since this attribute is private to Numba
        args, return_type = normalize_signature(sig)
        if tuple(args) not in this.overloads:
            with this._compiling_counter:
                this.overloads[tuple(args)] = this._compiler.compile(args, return_type)
        return this.overloads[tuple(args)].entry_point


class Kernel(CPUDispatcher):
    """A compiled function: a program of its own when called from Python, a part when called from other kernels."""

    def __init__(self, py_func: Any, targetoptions: dict[str, Any]) -> None:
        super().__init__(py_func, targetoptions=targetoptions, pipeline_class=_ProgramCompiler)
        alone = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
        self._part = _Part(py_func, targetoptions={**targetoptions, **alone}, pipeline_class=_PartCompiler)

    @property
    def _numba_type_(self) -> Any:
        return self._part._numba_type_

    def enable_caching(self) -> None:
        """Cache compiled code where every copy of Regista with the same sources finds it."""
        self._cache = KernelCache(self.py_func)

    def compile(self, sig: Any) -> Any:
        """Load or compile the kernel. Only one of several processes compiles; the others wait and load its result."""
        name = f"{self.stats.cache_path}.{self.py_func.__qualname__}.lock"
        cached = sig in self.overloads or self._cache.holds(sig, self.targetctx)
        with nullcontext() if cached else _turn(name), _in_haste():
            return super().compile(sig)


@contextmanager
def _turn(name: str) -> Iterator[None]:
    """Hold a lock on this file, or none if the folder is read-only or does not support locks.

    The operating system frees the lock of a process that is killed.
    """
    with ExitStack() as held:
        with suppress(OSError):
            file = held.enter_context(open(name, "w"))
            held.callback(_unlock, file)
            _lock(file)
        yield


def _lock(file: IO[str]) -> None:
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        with notices.waiting():
            fcntl.flock(file, fcntl.LOCK_EX)


def _unlock(file: IO[str]) -> None:
    """Free the lock. Closing the file does not suffice: a process forked in the meantime also holds it open."""
    with suppress(OSError):
        fcntl.flock(file, fcntl.LOCK_UN)
