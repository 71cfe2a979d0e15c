#include "base/plain.h"

#include <stdint.h>
#include <string.h>

static bool is_odd(uint32_t c)
{
	return (c >= 0x80 && c < 0xa0) || c == 0x61c || c == 0x200e || c == 0x200f || (c >= 0x2028 && c <= 0x202e) || (c >= 0x2066 && c <= 0x2069);
}

/* Returns how many bytes an odd character has; 0: what is there is shown. */
static size_t odd_bytes(const char *text, size_t left, bool *cut)
{
	const unsigned char *at = (const unsigned char *)text;
	const size_t length = at[0] < 0x80 ? 1 : (at[0] & 0xe0) == 0xc0 ? 2 : (at[0] & 0xf0) == 0xe0 ? 3 : 1;
	if (cut != NULL)
		*cut = false;
	if (at[0] < 0x80)
		return (at[0] < 0x20 && at[0] != '\n' && at[0] != '\t') || at[0] == 0x7f;
	if (length == 1) /* of four bytes, or no UTF-8: a byte of C1 alone is one in other encodings */
		return at[0] < 0xa0;
	uint32_t c = at[0] & (length == 2 ? 0x1f : 0x0f);
	for (size_t i = 1; i < length; i++) {
		if (i == left && cut != NULL)
			*cut = true;
		if (i >= left || (at[i] & 0xc0) != 0x80)
			return 0;
		c = c << 6 | (at[i] & 0x3f);
	}
	return is_odd(c) ? length : 0;
}

/* Returns how many bytes a character has that is shown. So its later bytes are not taken for others. */
static size_t shown(const char *text, size_t left)
{
	const unsigned char *at = (const unsigned char *)text;
	size_t length = at[0] < 0xc0 ? 1 : at[0] < 0xe0 ? 2 : at[0] < 0xf0 ? 3 : at[0] < 0xf8 ? 4 : 1, i = 1;
	while (i < length && i < left && (at[i] & 0xc0) == 0x80)
		i++;
	return i;
}

size_t plain_next(const char *at, size_t left, bool *odd, bool *cut)
{
	const size_t length = odd_bytes(at, left, cut);
	*odd = length > 0;
	return length > 0 ? length : shown(at, left);
}

void plain_line(char *text)
{
	const char *end = text + strlen(text);
	char *to = text;
	for (const char *at = text; at < end;) {
		bool odd;
		const size_t length = plain_next(at, (size_t)(end - at), &odd, NULL);
		if (odd || *at == '\n' || *at == '\t')
			*to++ = odd && (unsigned char)*at > 0x7f ? '?' : ' ';
		else
			for (size_t i = 0; i < length; i++)
				*to++ = at[i];
		at += length;
	}
	*to = '\0';
}
