"""Environment variables that must be set before importing Mitsuba."""
import glob
import os


def llvm_library():
    """Returns the path of an LLVM library for Dr.Jit 1.5, or None. Version 19 works (Debian: libllvm19).
    Versions 15 and 16 abort on machines with AVX-512, and Dr.Jit rejects 14."""
    if "DRJIT_LIBLLVM_PATH" in os.environ:
        return os.environ["DRJIT_LIBLLVM_PATH"]
    found = sorted(glob.glob("/usr/lib/*/libLLVM.so.19*"))
    return found[0] if found else None


def use_llvm():
    """Returns whether Mitsuba's llvm variants work. Must be called before mitsuba is imported."""
    library = llvm_library()
    if library:
        os.environ["DRJIT_LIBLLVM_PATH"] = library
    return library is not None
