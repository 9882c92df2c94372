"""How kernels that call each other become machine code once: where Python calls them, not at every call on the way.

Numba makes a program of each compiled function: it links all that the function calls, optimises the whole and makes
machine code of it, so that a chain of n calls is optimised n times over, and wraps each for calls from Python. Most of
our kernels are only ever called by others. So a `Kernel` is two: the part that other kernels link, which stays as it
came from Numba's front end, and the program of its own that it becomes where Python calls it. Half of the first
compilation goes with that; the machine code of what Python calls is the same.
Read next: `kernels.jit`, which makes kernels.
"""

from __future__ import annotations

import fcntl
import gc
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from typing import Any

from numba.core import errors
from numba.core.codegen import JITCodeLibrary, JITCPUCodegen
from numba.core.compiler import Compiler
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import CPUDispatcher
from numba.core.sigutils import normalize_signature
from numba.core.types.functions import BaseFunction

from regista.kernels.numba_cache import KernelCache

# Stages for what no kernel has: contexts, closures, exceptions, expressions of arrays, functions to inline as source.
NEEDLESS = {
    *("WithLifting", "InlineClosureLikes", "RewriteDynamicRaises", "MakeFunctionToJitFunction", "InlineInlinables"),
    *("FindLiterallyCalls", "LiteralUnroll", "LiteralPropagationSubPipelinePass", "InlineOverloads"),
    "NopythonRewrites",
}
GARBAGE = 100_000  # objects made, fewer those freed, before young ones are looked through; Python's 700 cost a tenth


class _PartLibrary(JITCodeLibrary):
    """The code of one part: neither optimised nor made machine code; it hands over all parts below it in one module."""

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
            while len(modules) > 1:  # in pairs: each time LLVM reads all of the module that it links another into
                for module, other in zip(modules[::2], modules[1::2], strict=False):
                    module.link_in(other)
                modules = modules[::2]
            for library in libraries:
                if not isinstance(library, _PartLibrary):
                    modules[0].link_in(library._get_module_for_linking(), preserve=True)
            self._shared_module = modules[0]
        return self._shared_module

    def _own_module(self) -> Any:
        """Return a copy of the module of this part alone, whose functions several programs may hold."""
        module = self._final_module.clone()
        for function in module.functions:
            if not function.is_declaration and function.linkage.name == "external":
                function.linkage = "weak_odr"  # which stays while nobody calls it yet
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
    """The code of a program: nobody but its own entry calls what it has linked, and so the optimiser may do more."""

    def _optimize_final_module(self) -> None:
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage.name in ("linkonce_odr", "weak_odr"):
                function.linkage = "internal"
        super()._optimize_final_module()


class _PartCodegen(JITCPUCodegen):
    """Numba's code generator, with the same engine, except that it makes libraries of parts; a part has no address."""

    _library_class = _PartLibrary

    def __init__(self, usual: Any) -> None:
        vars(self).update(vars(usual))
        self.usual = usual

    def set_env(self, name: str, environment: Any) -> None:
        """Do nothing: what Python objects a function needs is only asked for in errors, and kernels never raise."""


class _PartCompiler(Compiler):
    """Numba's compiler up to its intermediate code."""

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


def _run_pass(analysis: Any, _: int, step: Any, state: Any) -> None:
    """Run one pass without Numba's report of it, which writes out the types of all arguments."""
    step.analysis = analysis
    step.run_pass(state)


class _ProgramCompiler(_PartCompiler):
    """Numba's compiler; of the bodies of parallel loops and what Numba wraps round them it makes parts, too."""

    def compile_extra(self, func: Any) -> Any:
        library = self.state.library = _ProgramLibrary(self.state.targetctx.codegen().usual, func.__qualname__)
        library.enable_object_caching()
        return super().compile_extra(func)


@contextmanager
def _in_haste() -> Iterator[None]:
    """Spare Numba what it does again and again: typing an operator, colouring errors that it drops, seeking garbage."""
    operators: Any = BaseFunction
    colours: Any = type(errors.termcolor())
    typed, coloured, thresholds = operators.get_call_type, colours.errmsg, gc.get_threshold()
    signatures: dict[Any, Any] = {}

    def typed_once(function: Any, context: Any, args: Any, kws: dict[str, Any]) -> Any:
        key = function, context, args, *kws.items()
        if key not in signatures:
            signatures[key] = typed(function, context, args, kws)
        return signatures[key]

    with global_compiler_lock:
        operators.get_call_type, colours.errmsg = typed_once, lambda _, message: message
        gc.set_threshold(GARBAGE, *thresholds[1:])
        try:
            yield
        finally:
            operators.get_call_type, colours.errmsg = typed, coloured
            gc.set_threshold(*thresholds)


class _Part(CPUDispatcher):
    """A kernel as other kernels see it."""

    def compile(self, sig: Any) -> Any:
        this: Any = self  # as Numba knows itself
        args, return_type = normalize_signature(sig)
        if tuple(args) not in this.overloads:
            with this._compiling_counter:
                this.overloads[tuple(args)] = this._compiler.compile(args, return_type)
        return this.overloads[tuple(args)].entry_point


class Kernel(CPUDispatcher):
    """A compiled function: called from Python a program of its own, called from other kernels a part of theirs."""

    def __init__(self, py_func: Any, targetoptions: dict[str, Any]) -> None:
        super().__init__(py_func, targetoptions=targetoptions, pipeline_class=_ProgramCompiler)
        alone = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
        self._part = _Part(py_func, targetoptions={**targetoptions, **alone}, pipeline_class=_PartCompiler)

    @property
    def _numba_type_(self) -> Any:
        return self._part._numba_type_

    def enable_caching(self) -> None:
        """Keep what is compiled where every copy of Regista with the same sources finds it."""
        self._cache = KernelCache(self.py_func)

    def compile(self, sig: Any) -> Any:
        """Load or compile it; programs that begin together wait for the one that compiles, and load what it made."""
        with ExitStack() as held:
            with suppress(OSError):  # a folder that nobody may write into, or that knows no locks
                name = f"{self.stats.cache_path}.{self.py_func.__qualname__}.lock"
                fcntl.flock(held.enter_context(open(name, "w")), fcntl.LOCK_EX)
            held.enter_context(_in_haste())
            return super().compile(sig)
