// No program: what precompiles the headers of all tests.
