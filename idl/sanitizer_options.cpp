// Options that the sanitizers read at start, for every executable that links the bus. The vendors' libraries are not
// built with sanitizers: what they do among themselves is not reported, what our code does is.
extern "C" const char* __asan_default_options();  // NOLINT
extern "C" const char* __tsan_default_options();  // NOLINT

// Fast DDS 2.9 deletes one of its own objects as another type.
extern "C" const char* __asan_default_options() {  // NOLINT
  return "new_delete_type_mismatch=0";
}

// The thread sanitizer cannot see the locks in the vendors' code.
extern "C" const char* __tsan_default_options() {  // NOLINT
  return "ignore_noninstrumented_modules=1";
}
