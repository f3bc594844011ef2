// The vendors' libraries are not built with the thread sanitizer, so it cannot see their locks: what they do among
// themselves is not reported, what our code does is. Read by the sanitizer at start; unused in other builds.
extern "C" const char* __tsan_default_options();   // NOLINT
extern "C" const char* __tsan_default_options() {  // NOLINT
  return "ignore_noninstrumented_modules=1";
}
