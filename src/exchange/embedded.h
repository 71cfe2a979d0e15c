/* The page, src/exchange/page.html, embedded by embed.py. */
#ifndef FURROW_EXCHANGE_EMBEDDED_H
#define FURROW_EXCHANGE_EMBEDDED_H

extern const unsigned char exchange_page[];
extern const unsigned long exchange_page_size;

#endif
