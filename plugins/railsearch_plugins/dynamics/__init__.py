"""Array kernels shared by all track models: beam elements, assembly, moving contact, time integration."""
