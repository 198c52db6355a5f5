#include "cli_list.h"

#include <stdlib.h>
#include <string.h>

#include "cli_util.h"

enum { MOST_NUMBERS = 10000000 };

/* ---- Parts between commas ---------------------------------------------------------------------------------- */

static int out_of_memory(void) {
    nsdf_cli_error("out of memory");
    return NSDF_CLI_FAILURE;
}

int nsdf_cli_each_item(const char *list, nsdf_cli_item_fn item, void *user) {
    char *const copy = malloc(strlen(list) + 1);
    if (!copy)
        return out_of_memory();
    strcpy(copy, list);
    int result = NSDF_CLI_SUCCESS;
    for (char *text = copy; text && result == NSDF_CLI_SUCCESS;) {
        char *comma = strchr(text, ',');
        if (comma)
            *comma = 0;
        result = item(user, text);
        text = comma ? comma + 1 : NULL;
    }
    free(copy);
    return result;
}

/* ---- Frame numbers ----------------------------------------------------------------------------------------- */

typedef struct range {
    uint32_t first, last, step;
} range;

/* Reads the number at *at and moves behind it. */
static int take_number(const char **at, uint32_t *out) {
    char digits[16];
    const size_t length = strspn(*at, "0123456789");
    if (length >= sizeof digits)
        return -1;
    memcpy(digits, *at, length);
    digits[length] = 0;
    *at += length;
    return nsdf_cli_parse_u32(digits, 0, UINT32_MAX, out);
}

static int parse_range(const char *text, range *r) {
    const char *at = text;
    r->step = 1;
    if (take_number(&at, &r->first) != 0)
        return -1;
    r->last = r->first;
    if (*at == '-') {
        at++;
        if (take_number(&at, &r->last) != 0)
            return -1;
        if (*at == '/') {
            at++;
            if (take_number(&at, &r->step) != 0 || r->step == 0)
                return -1;
        }
    }
    return *at ? -1 : 0;
}

static int add_range(nsdf_cli_list *list, const char *option, const range *r) {
    const uint32_t count = (r->last - r->first) / r->step + 1;
    if (count > MOST_NUMBERS || list->count > MOST_NUMBERS - count) {
        nsdf_cli_error("%s: more than %d frames", option, MOST_NUMBERS);
        return NSDF_CLI_FAILURE;
    }
    if (list->count + count > list->capacity) {
        const uint32_t capacity = 2 * list->capacity + count + 64;
        uint32_t *grown = realloc(list->numbers, capacity * sizeof *grown);
        if (!grown)
            return out_of_memory();
        list->numbers = grown;
        list->capacity = capacity;
    }
    for (uint32_t i = 0; i < count; i++)
        list->numbers[list->count++] = r->first + i * r->step;
    return NSDF_CLI_SUCCESS;
}

typedef struct parsing {
    nsdf_cli_list *list;
    const char *option;
    uint32_t frame_count;
} parsing;

static int add_item(void *user, const char *text) {
    const parsing *p = user;
    range r;
    if (parse_range(text, &r) != 0)
        return nsdf_cli_usage_error("%s: '%s' is not a number or a range such as 0-9 or 0-98/2", p->option, text);
    if (r.first > r.last)
        return nsdf_cli_usage_error("%s: '%s' runs backwards", p->option, text);
    if (r.last >= p->frame_count)
        return nsdf_cli_usage_error("%s: there is no frame %lu, they go from 0 to %lu", p->option,
                                    (unsigned long)r.last, (unsigned long)p->frame_count - 1);
    return add_range(p->list, p->option, &r);
}

int nsdf_cli_list_parse(nsdf_cli_list *list, const char *option, const char *text, uint32_t frame_count) {
    parsing p = {list, option, frame_count};
    memset(list, 0, sizeof *list);
    return nsdf_cli_each_item(text, add_item, &p);
}

int nsdf_cli_list_all(nsdf_cli_list *list, uint32_t frame_count) {
    const range all = {0, frame_count - 1, 1};
    memset(list, 0, sizeof *list);
    return add_range(list, "frames", &all);
}

static int compare_numbers(const void *a, const void *b) {
    const uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

void nsdf_cli_list_sort(nsdf_cli_list *list) {
    uint32_t kept = 0;
    if (list->count == 0)
        return;
    qsort(list->numbers, list->count, sizeof *list->numbers, compare_numbers);
    for (uint32_t i = 1; i < list->count; i++)
        if (list->numbers[i] != list->numbers[kept])
            list->numbers[++kept] = list->numbers[i];
    list->count = kept + 1;
}

void nsdf_cli_list_free(nsdf_cli_list *list) {
    free(list->numbers);
    memset(list, 0, sizeof *list);
}
