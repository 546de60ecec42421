// Source of the precompiled header that all tests share.
