nsdf-enc --version
