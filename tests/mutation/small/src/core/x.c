/* SPDX-License-Identifier: MIT */
int dg_limit(int n);
int dg_unseen(int n);

int dg_limit(int n)
{
    if (n < 3) {
        return 1;
    }
    if (n != n) {
        return 2;
    }
    return 5;
}

int dg_unseen(int n)
{
    return n + 7;
}
