// A library that is not VirtuoseAPI, although it begins like it.
extern "C" __attribute__((visibility("default"))) void* virtOpen(const char*) { return nullptr; }
