"""What Mitsuba has to find before it is imported."""
import glob
import os


def llvm_library():
    """Path of an LLVM that Dr.Jit 1.5 works with, or None. 19 does (Debian: libllvm19); 15 and 16
    abort on machines with AVX-512, and 14 is refused."""
    if "DRJIT_LIBLLVM_PATH" in os.environ:
        return os.environ["DRJIT_LIBLLVM_PATH"]
    found = sorted(glob.glob("/usr/lib/*/libLLVM.so.19*"))
    return found[0] if found else None


def use_llvm():
    """True if Mitsuba's llvm variants will work; must be called before mitsuba is imported."""
    library = llvm_library()
    if library:
        os.environ["DRJIT_LIBLLVM_PATH"] = library
    return library is not None
