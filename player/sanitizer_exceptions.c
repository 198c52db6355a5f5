/* What sanitizers are not to report: Mesa is not instrumented, so that its own threads look as if they raced, and it
 * frees the buffers of an OSMesa context at the end of the process only.  Part of sanitized builds; the sanitizers call
 * these functions by name. */
const char *__lsan_default_options(void);
const char *__lsan_default_suppressions(void);
const char *__tsan_default_suppressions(void);

const char *__lsan_default_options(void) {
    return "print_suppressions=0";
}

const char *__lsan_default_suppressions(void) {
    return "leak:libOSMesa.so\n";
}

const char *__tsan_default_suppressions(void) {
    return "race:swrast_dri.so\nrace:libOSMesa.so\n";
}
