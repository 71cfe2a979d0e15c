#include "xml.h"

/* Returns the bytes of the character at `at`; 0: it is no UTF-8. */
static int character(const unsigned char *at)
{
	const int length = at[0] < 0x80 ? 1 : at[0] < 0xc2 ? 0 : at[0] < 0xe0 ? 2 : at[0] < 0xf0 ? 3 : at[0] < 0xf5 ? 4 : 0;
	for (int i = 1; i < length; i++)
		if ((at[i] & 0xc0) != 0x80)
			return 0;
	if ((at[0] == 0xe0 && at[1] < 0xa0) || (at[0] == 0xed && at[1] > 0x9f) || (at[0] == 0xf0 && at[1] < 0x90) || (at[0] == 0xf4 && at[1] > 0x8f))
		return 0; /* too long, a surrogate, or too large */
	return at[0] == 0xef && at[1] == 0xbf && at[2] >= 0xbe ? 0 : length; /* U+FFFE and U+FFFF are none of XML's */
}

void xml_text(const char *text, FILE *file)
{
	for (const unsigned char *at = (const unsigned char *)text; *at != '\0';) {
		const int length = character(at);
		if (*at == '<')
			fputs("&lt;", file);
		else if (*at == '>')
			fputs("&gt;", file);
		else if (*at == '&')
			fputs("&amp;", file);
		else if (*at == '"')
			fputs("&quot;", file);
		else if (length == 0 || *at < ' ' || *at == 0x7f)
			fputc('?', file);
		else
			fwrite(at, 1, (size_t)length, file);
		at += length > 0 ? length : 1;
	}
}
