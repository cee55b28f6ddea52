/* What is printed: text for people, JSON, and comma-separated values. */
#include "cmd.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The length of the UTF-8 sequence at text, or 0 when there is no valid one. */
static size_t sequence_length(const unsigned char *text) {
    static const unsigned least[] = {0, 0, 0x80, 0x800, 0x10000};
    size_t length = text[0] < 0x80 ? 1 : text[0] < 0xc0 ? 0 : text[0] < 0xe0 ? 2 : text[0] < 0xf0 ? 3 : 4;
    if (length < 2) return length;
    unsigned code = text[0] & (0x7fu >> length);
    for (size_t i = 1; i < length; i++) {
        if ((text[i] & 0xc0) != 0x80) return 0;
        code = code << 6 | (text[i] & 0x3fu);
    }
    bool surrogate = code >= 0xd800 && code < 0xe000;
    return code < least[length] || code > 0x10ffff || surrogate || text[0] >= 0xf8 ? 0 : length;
}

/* A control character would act on the terminal: those below a space, DEL, and U+0080 to U+009F. */
static bool is_control(const unsigned char *text, size_t length) {
    return length == 1 ? *text < ' ' || *text == 0x7f : length == 2 && text[0] == 0xc2 && text[1] < 0xa0;
}

void cmd_print_plain(FILE *to, const char *text) {
    for (const unsigned char *c = (const unsigned char *)text; *c;) {
        size_t length = sequence_length(c);
        if (length == 0 || is_control(c, length))
            putc('?', to);
        else
            fwrite(c, 1, length, to);
        c += length ? length : 1;
    }
}

void cmd_print_number(double number) {
    char text[40];
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(text, sizeof text, "%.*g", digits, number);
        if (strtod(text, NULL) == number) break;
    }
    printf("%s", text);
}

/* ---- JSON ---- */

/* A file's name may hold any byte. One that is no UTF-8 is shown as the character of the same number. */
static void print_string(const char *text) {
    putchar('"');
    for (const unsigned char *c = (const unsigned char *)text; *c;) {
        size_t length = sequence_length(c);
        if (*c == '"' || *c == '\\')
            printf("\\%c", *c);
        else if (length == 0 || is_control(c, length))
            printf("\\u%04X", length == 2 ? c[1] : *c);
        else
            fwrite(c, 1, length, stdout);
        c += length ? length : 1;
    }
    putchar('"');
}

/* Whether a value stands in front of the next one, in the same brackets. */
static bool follows;

static void begin_value(const char *key) {
    if (follows) printf(", ");
    follows = true;
    if (!key) return;
    print_string(key);
    printf(": ");
}

void cmd_json_open(const char *key, char bracket) {
    begin_value(key);
    putchar(bracket);
    follows = false;
}

void cmd_json_close(char bracket) {
    putchar(bracket);
    follows = true;
}

void cmd_json_end(void) {
    printf("}\n");
    follows = false;
}

void cmd_json_text(const char *key, const char *text) {
    begin_value(key);
    if (text)
        print_string(text);
    else
        printf("null");
}

void cmd_json_number(const char *key, double number) {
    begin_value(key);
    if (isfinite(number))
        cmd_print_number(number);
    else
        printf("null");
}

void cmd_json_known(const char *key, double number) {
    cmd_json_number(key, number >= 0 ? number : (double)NAN);
}

void cmd_json_integer(const char *key, long long number) {
    begin_value(key);
    printf("%lld", number);
}

void cmd_json_integers(const char *key, int count, const int numbers[]) {
    cmd_json_open(key, '[');
    for (int i = 0; i < count; i++)
        cmd_json_integer(NULL, numbers[i]);
    cmd_json_close(']');
}

void cmd_json_flag(const char *key, bool flag) {
    begin_value(key);
    printf(flag ? "true" : "false");
}

void cmd_json_window(const char *key, const hdr_window *window) {
    cmd_json_integers(key, 4, (const int[]){window->min_x, window->min_y, window->max_x, window->max_y});
}

/* ---- Comma-separated values ---- */

void cmd_print_csv_text(const char *text) {
    bool quoted = text[strcspn(text, ",\"\r\n")] != '\0';
    if (quoted) putchar('"');
    for (; *text; text++) {
        if (*text == '"') putchar('"');
        putchar(*text);
    }
    if (quoted) putchar('"');
}
